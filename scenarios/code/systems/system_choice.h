/// `system:` of a scenario: one of ours by name, or somebody else's as a shared library, a running process, or a
/// command on a written dataset.
///
///   system: mobif_vo
///   system: {name: mobif_vo, feature: akaze, ratio: 0.8}
///   system: {plugin: ./libmy_slam.so, ratio: 0.8}                       # algorithms/slam/plugin.h
///   system: {process: [python3, my_slam.py], needs: [imu]}              # frame_protocol.h
///   system: {command: [./my_slam, "{dataset}", "{output}"], format: tum}
///   system: {command: [./vslamlab_orbslam2], interface: vslamlab, mode: mono}
///
/// Somebody else's program sees its own files, those that its words and `depends` name, and what it is handed
/// (sandbox.h).

#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "algorithms/core/enum_words.h"
#include "algorithms/core/fields.h"
#include "algorithms/core/option_reader.h"
#include "algorithms/io/dataset_layout.h"
#include "algorithms/io/trajectory_file.h"
#include "algorithms/slam/system.h"

namespace YAML {
class Emitter;
}

namespace gaitcam {

/// How a command is told what to do.
enum class CommandInterface { kPlaceholders, kVslamlab };
constexpr auto WordsOf(CommandInterface) {
  return std::array{EnumWord{CommandInterface::kPlaceholders, "placeholders"},
                    EnumWord{CommandInterface::kVslamlab, "vslamlab"}};
}

/// What a command of VSLAM-LAB's interface uses of a sequence.
enum class VslamlabMode { kMono, kStereo, kRgbd, kMonoImu, kStereoImu };
constexpr auto WordsOf(VslamlabMode) {
  return std::array{EnumWord{VslamlabMode::kMono, "mono"}, EnumWord{VslamlabMode::kStereo, "stereo"},
                    EnumWord{VslamlabMode::kRgbd, "rgbd"}, EnumWord{VslamlabMode::kMonoImu, "mono-vi"},
                    EnumWord{VslamlabMode::kStereoImu, "stereo-vi"}};
}

/// An executable that reads a dataset folder and writes a trajectory file.
struct CommandChoice {
  using DescribedTag = void;
  std::vector<std::string> command;
  CommandInterface interface = CommandInterface::kPlaceholders;
  DatasetFormat dataset = DatasetFormat::kTum;
  TrajectoryFormat format = TrajectoryFormat::kTum;
  VslamlabMode mode = VslamlabMode::kMono;
  double time_limit_s = 600;
  double memory_mb = 0;
  std::optional<std::vector<std::string>> depends;
  std::string name;
};

template <class Visitor>
void VisitFields(Visitor& visit, CommandChoice& o) {
  visit("command", o.command, Nested(),
        "program and arguments; {dataset}, {output}, {calibration}, {seed} are filled in. What names a file is looked "
        "for beside the scenario file first");
  visit("interface", o.interface, EnumWords<CommandInterface>(),
        "placeholders; or vslamlab: called with key:value arguments on a VSLAM-LAB sequence");
  visit("dataset", o.dataset, EnumWords<DatasetFormat>(), "layout of the dataset folder that it reads");
  visit("format", o.format, EnumWords<TrajectoryFormat>(), "of the trajectory that it writes");
  visit("mode", o.mode, EnumWords<VslamlabMode>(), "interface vslamlab: what it uses of the sequence");
  visit("time_limit_s", o.time_limit_s, Between(0.1, 1e6), "then it is killed, with all that it started");
  visit("memory_mb", o.memory_mb, Between(0, 1e9),
        "memory of it and all that it starts, together: with more it is killed; 0: three quarters of the machine's");
  visit("depends", o.depends, Nested(), "further files and folders that it reads; all else of the user's is hidden");
  visit("name", o.name, AnyText(), "as scores and tables call it; the program's name unless given");
}

/// A program that answers frame by frame (frame_protocol.h).
struct ProcessChoice {
  using DescribedTag = void;
  std::vector<std::string> process;
  std::vector<SensorNeed> needs;
  bool acts = false;
  SystemSettings settings;
  double start_limit_s = 60;
  double frame_limit_s = 10;
  double finish_limit_s = 600;
  double memory_mb = 0;
  std::optional<std::vector<std::string>> depends;
  std::string name;
};

template <class Visitor>
void VisitFields(Visitor& visit, ProcessChoice& o) {
  visit("process", o.process, Nested(),
        "program and arguments. What names a file is looked for beside the scenario file first");
  visit("needs", o.needs, Nested(), "sensors without which it cannot work");
  visit("acts", o.acts, Nested(), "it commands the robot: its answers may hold a command");
  visit("settings", o.settings, Nested(), "names and values that it is told when it starts");
  visit("start_limit_s", o.start_limit_s, Between(0.1, 1e6), "for its answer to the start");
  visit("frame_limit_s", o.frame_limit_s, Between(0.01, 1e6), "for its answer to a frame");
  visit("finish_limit_s", o.finish_limit_s, Between(0.1, 1e6), "for its last answer");
  visit("memory_mb", o.memory_mb, Between(0, 1e9),
        "memory of it and all that it starts, together: with more it is killed; 0: three quarters of the machine's");
  visit("depends", o.depends, Nested(), "further files and folders that it reads; all else of the user's is hidden");
  visit("name", o.name, AnyText(), "as scores and tables call it; the program's name unless given");
}

/// A shared library with a system in it. Keys beside these are the system's settings.
struct PluginChoice {
  using DescribedTag = void;
  std::string plugin;
  double frame_limit_s = 60;
  double finish_limit_s = 600;
  double memory_mb = 0;
  std::optional<std::vector<std::string>> depends;
};

template <class Visitor>
void VisitFields(Visitor& visit, PluginChoice& o) {
  visit("plugin", o.plugin, AnyText(), "shared library; looked for beside the scenario file first");
  visit("frame_limit_s", o.frame_limit_s, Between(0.01, 1e6), "for its answer to a frame");
  visit("finish_limit_s", o.finish_limit_s, Between(0.1, 1e6), "for its last answer");
  visit("memory_mb", o.memory_mb, Between(0, 1e9),
        "memory of it and all that it starts, together: with more it is killed; 0: three quarters of the machine's");
  visit("depends", o.depends, Nested(), "further files and folders that it reads; all else of the user's is hidden");
}

struct SystemChoice {
  std::string name = "sift_vo";          ///< Ours, or as tables call somebody else's.
  SystemSettings settings;               ///< Of ours, and of a plugin's.
  std::optional<CommandChoice> command;  ///< At most one of these three.
  std::optional<ProcessChoice> process;
  std::optional<PluginChoice> plugin;

  bool IsForeign() const { return command || process || plugin; }
};

/// The settings that a map has beside the keys `except`. A setting within a group is named with a dot, whether it is
/// written `{matching.ratio: 0.8}` or `{matching: {ratio: 0.8}}`.
/// @throws BadInput for a list.
SystemSettings ReadSettings(const OptionValue& node, const std::vector<std::string>& except = {"name"});
void ReadOption(const OptionValue& node, SystemSettings& value);
void ReadOption(const OptionValue& node, SystemChoice& value);
void WriteYaml(YAML::Emitter& out, const SystemSettings& value);
void WriteYaml(YAML::Emitter& out, const SystemChoice& value);

/// What a command line names: one of ours, a shared library (.so), a map as above, or a YAML file that holds one.
/// @param sets "name=value", settings on top
/// @throws BadInput.
SystemChoice ParseSystemChoice(const std::string& text, const std::vector<std::string>& sets = {});

/// Words that name files become absolute paths: of those in `folder` first, then of those in the working folder.
/// @param node that was read, where messages point
/// @throws BadInput, located: a program or file that is not there.
void ResolveFiles(const OptionValue& node, const std::filesystem::path& folder, SystemChoice& choice);

/// Files and folders of a foreign system: its program, those among its words, and what it depends on.
/// @pre resolved.
std::vector<std::filesystem::path> FilesOf(const SystemChoice& choice);

/// The choice without saying where its files lie: what of it belongs to a run's hash.
SystemChoice WithoutFolders(SystemChoice choice);

/// SHA-256 of what those files hold; empty for one of ours.
std::string FingerprintOf(const SystemChoice& choice);
/// Whether nothing else of the user's can decide what it answers: it runs in a sandbox (sandbox.h), or says what it
/// depends on.
bool IsFingerprintComplete(const SystemChoice& choice);

}  // namespace gaitcam
