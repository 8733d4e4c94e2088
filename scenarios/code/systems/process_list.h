/// Who runs on this machine, as /proc tells. Processes come and go meanwhile: each answer is of the past.

#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace gaitcam {

/// Processes whose environment holds `mark`, as far as we may read it.
std::vector<pid_t> Marked(const std::string& mark);

/// Our children, dead ones included, as far as nobody has waited for them.
std::vector<pid_t> Children();

/// Children of any process of one thread; none if it has gone.
std::vector<pid_t> ChildrenOf(pid_t parent);

/// Processes and threads on this machine, all containers' together; 0 if the kernel does not say.
size_t MachineTasks();

/// `root`, all that descend from it through parents that still live, and all marked ones with theirs. Only others' than
/// the root's descendants are asked for marks: a process that forks, or waits for its turn to, holds the answer back.
std::vector<pid_t> Family(pid_t root, const std::string& mark);

/// Memory in use that is of no file and not shared with others, bytes; of a process that has gone 0. Pages that a fork
/// left in common with its parent count in full for both.
uint64_t PrivateMemory_bytes(pid_t pid);

/// Memory of this machine, or of the control group that we are in if that is allowed less, bytes.
uint64_t MachineMemory_bytes();

}  // namespace gaitcam
