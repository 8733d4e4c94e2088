// A real Slurm of one node, made of Debian's daemons, in a folder of its own and with ports of its own.

#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <list>
#include <string>
#include <thread>

#include "scenarios/code/systems/subprocess.h"
#include "tests/scenarios/program.h"
#include "tests/temporary_folder.h"

namespace gaitcam {

class SlurmCluster {
 public:
  SlurmCluster() {
    if (getuid() != 0) {
      trouble_ = "Slurm's daemons start jobs as root only";
      return;
    }
    for (const char* program : {"munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol"}) {
      if (FindProgram(program)) continue;
      trouble_ = std::string("no ") + program + " on this machine (Debian: slurm-wlm, munge)";
      return;
    }
    Start();
  }
  ~SlurmCluster() {
    if (trouble_.empty()) RunShell(Slurm() + "scancel --state=RUNNING --state=PENDING --user=root; sleep 0.5", path());
  }

  /// Empty if the cluster works; else why it does not.
  const std::string& trouble() const { return trouble_; }
  /// Words before a command of a shell that make it speak to this cluster.
  std::string Slurm() const { return "SLURM_CONF=" + (path() / "slurm.conf").string() + " "; }
  std::string configuration() const { return (path() / "slurm.conf").string(); }

  /// What a command of Slurm's says.
  std::string Ask(const std::string& command) const { return RunShell(Slurm() + command, path()).out; }

 private:
  const std::filesystem::path& path() const { return folder_.path(); }

  static int FreePort() {
    const int descriptor = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    bind(descriptor, reinterpret_cast<sockaddr*>(&address), size);
    getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
    close(descriptor);
    return ntohs(address.sin_port);
  }

  void Configure() {
    char name[256] = "localhost";
    gethostname(name, sizeof(name) - 1);
    const std::string host = std::string(name).substr(0, std::string(name).find('.')), here = path().string() + "/";
    std::ofstream(path() / "slurm.conf")
        << "ClusterName=gaitcam\nSlurmctldHost=" << host << "(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\n"
        << "AuthType=auth/munge\nAuthInfo=socket=" << here << "munge.socket\nCredType=cred/munge\n"
        << "SlurmctldPort=" << FreePort() << "\nSlurmdPort=" << FreePort() << "\n"
        << "StateSaveLocation=" << here << "state\nSlurmdSpoolDir=" << here << "spool\n"
        << "SlurmctldPidFile=" << here << "slurmctld.pid\nSlurmdPidFile=" << here << "slurmd.pid\n"
        << "SlurmctldLogFile=" << here << "slurmctld.log\nSlurmdLogFile=" << here << "slurmd.log\n"
        << "ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n"
        << "SelectTypeParameters=CR_Core\nMpiDefault=none\nReturnToService=2\nSwitchType=switch/none\n"
        << "SchedulerParameters=sched_interval=1,batch_sched_delay=0\n"
        << "NodeName=" << host << " NodeAddr=127.0.0.1 CPUs=1 RealMemory=500\n"
        << "PartitionName=main Nodes=ALL Default=YES State=UP MaxTime=INFINITE\n";
  }

  void Start() {
    std::filesystem::permissions(path(), std::filesystem::perms(0755));
    for (const char* name : {"state", "spool"}) std::filesystem::create_directory(path() / name);
    const std::string here = path().string() + "/";
    RunShell("head -c 128 /dev/urandom >key && chmod 400 key", path());
    Configure();
    daemons_.emplace_back(
        std::vector<std::string>{"munged", "--foreground", "--force", "--socket=" + here + "munge.socket",
                                 "--key-file=" + here + "key", "--pid-file=" + here + "munged.pid",
                                 "--log-file=" + here + "munged.log", "--seed-file=" + here + "seed"},
        path() / "munged.out");
    const std::string conf = configuration();
    for (int i = 0; i < 100 && !std::filesystem::exists(path() / "munge.socket"); ++i) Wait(50);
    for (const char* daemon : {"slurmctld", "slurmd"})
      daemons_.emplace_back(std::vector<std::string>{daemon, "-D", "-f", conf},
                            path() / (std::string(daemon) + ".out"));
    for (int i = 0; i < 100; ++i) {
      if (Ask("sinfo --noheader --format=%T").find("idle") != std::string::npos) return;
      Wait(200);
    }
    trouble_ = "Slurm does not come up: " + LastLine(path() / "slurmctld.out") + " " + LastLine(path() / "slurmd.out");
  }

  static void Wait(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

  const TemporaryFolder folder_;
  std::list<Subprocess> daemons_;
  std::string trouble_;
};

}  // namespace gaitcam
