#include "scenarios/code/datasets/dataset_card.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "algorithms/core/errors.h"
#include "algorithms/core/file_content.h"
#include "algorithms/io/calibration_file.h"
#include "algorithms/io/checksum.h"
#include "algorithms/io/program_settings.h"
#include "algorithms/io/whole_file.h"
#include "scenarios/code/files/versions.h"

namespace gaitcam {
namespace fs = std::filesystem;
namespace {

/// A field of a CSV row, quoted where necessary.
std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string CellText(std::string text) {
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string LevelOf(const Condition& condition, const std::string& key) {
  for (const auto& [name, value] : condition.levels) {
    if (name == key) return value;
  }
  return "";
}

std::map<std::string, const SequenceRecord*> ByName(const std::vector<SequenceRecord>& records) {
  std::map<std::string, const SequenceRecord*> by_name;
  for (const SequenceRecord& record : records) by_name[record.name] = &record;
  return by_name;
}

std::string Summary(const RecordMatrix& matrix, const std::vector<SequenceRecord>& records) {
  int64_t frames = 0;
  double seconds = 0;
  int fallen = 0;
  for (const SequenceRecord& r : records) {
    frames += r.frames;
    seconds += r.end_time_s;
    fallen += r.status == "fell";
  }
  std::string text = fmt::format("{} of {} sequences, {} frames, {:.1f} s of walking.", records.size(),
                                 matrix.sequences.size(), frames, seconds);
  if (records.size() < matrix.sequences.size()) text += " **Not complete**: the same command records the rest.";
  if (fallen > 0) text += fmt::format(" In {} the robot fell: what was filmed until then is kept.", fallen);
  return text;
}

std::string AxesText(const RecordMatrix& matrix) {
  std::string text;
  for (const std::string& key : matrix.experiment.keys) {
    std::vector<std::string> values;
    for (const Condition& condition : matrix.experiment.conditions) {
      const std::string value = LevelOf(condition, key);
      if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
    }
    text += fmt::format("- `{}`: {}\n", key, fmt::join(values, ", "));
  }
  return text + fmt::format("- seeds: {}\n", fmt::join(matrix.options.seeds, ", "));
}

std::string SequenceTable(const RecordMatrix& matrix, const std::vector<SequenceRecord>& records) {
  const auto by_name = ByName(records);
  const bool preview = matrix.options.recording.preview, pairs = matrix.options.recording.pairs.enabled;
  std::string text = "| sequence |", rule = "|---|";
  for (const std::string& key : matrix.experiment.keys) {
    text += " " + ShortKey(key) + " |";
    rule += "---|";
  }
  text += std::string(" seed | frames | s | blur px, median / 90 % | ended |") + (pairs ? " pairs |" : "") +
          (preview ? " look |" : "") + "\n" + rule + "---|---|---|---|---|" + (pairs ? "---|" : "") +
          (preview ? "---|" : "") + "\n";
  for (const PlannedSequence& sequence : matrix.sequences) {
    const auto it = by_name.find(sequence.name);
    if (it == by_name.end()) continue;
    const SequenceRecord& r = *it->second;
    text += "| `" + r.name + "` |";
    for (const std::string& key : matrix.experiment.keys)
      text += " " + CellText(LevelOf(matrix.experiment.conditions[sequence.condition], key)) + " |";
    text += fmt::format(" {} | {} | {:.2f} | {:.1f} / {:.1f} | {} |", sequence.seed, r.frames, r.end_time_s,
                        r.blur_median_px, r.blur_p90_px, r.status);
    if (pairs) text += fmt::format(" {} |", r.pairs);
    const std::string truth = "sequences/" + r.name + "-truth/";
    if (preview) text += fmt::format(" [sheet]({0}contact_sheet.png), [film]({0}preview.mp4) |", truth);
    text += "\n";
  }
  return text;
}

/// Versions that made the sequences: more than one where a dataset was continued with another program.
std::string VersionsText(const std::vector<SequenceRecord>& records) {
  std::string text;
  for (const auto& [name, version] : LibraryVersions()) text += fmt::format("- {}: {}\n", name, version);
  std::map<std::string, int> made_by;
  for (const SequenceRecord& r : records)
    ++made_by[fmt::format("gaitcam {} ({}), {}", r.program, r.frames_fingerprint.substr(0, 12), r.renderer.ToText())];
  for (const auto& [by, count] : made_by) text += fmt::format("- {} sequences by {}\n", count, by);
  return text;
}

constexpr const char* kLayout = R"(## Layout

```
README.md        this card                        matrix.yaml   what was asked for
index.csv        one row per sequence             SHA256SUMS    check with: sha256sum -c SHA256SUMS
sequences/NAME/        what a SLAM system may see, {layout}
sequences/NAME-truth/  what is true of it; keep it from what is being evaluated
```

{sensors}
- `{calibration}`: intrinsics, extrinsics, IMU noise. `{times}`: exposure per frame in ms. `exposure.csv`: also how
  many IMU and joint samples belong to each frame. `joints.csv`: encoders (rad) and foot switches. `odometry.csv` (if
  the body has any): x, y (m) and heading (rad) by its wheels or legs. `settings/`: the
  calibration for other programs, see below.
- Truth: `groundtruth.txt` (TUM format, pose X_WC of the left camera at mid-exposure), `frames.csv` (poses at shutter
  open and close, blur, gait phase, foot contacts, root pose), `subposes.csv` (every averaged instant), `sharp/` (one
  instant at mid-exposure, no noise), `depth/` (16-bit PNG, 5000 per metre), `blur/` (vectors, 16-bit PNG:
  (red - 32768) / 64 px to the right, (green - 32768) / 64 px down, known where blue is 1), `scenario.yaml` (everything
  that made the sequence; `gaitcam record` of it gives it again).
{pairs}
## Units, frames, stamps

- Metres, radians, seconds, pixels; stamps are nanoseconds on one clock (in TUM tables: seconds with nine decimals),
  which shows 1 700 000 000 s when a walk begins: names of images have one length and sort by time.
- **An image's stamp is the middle of its exposure.** With a rolling shutter, of its middle row.
- X_AB maps points of B into A. World: x forward, y left, z up, floor at z = 0. Camera: x right, y down, z forward.
- Quaternions are Hamilton's, in files as x y z w (EuRoC's tables: w x y z). Pixel (0, 0) is the centre of the first.
- Blur of a frame: path length from shutter open to close of the points seen, median over the image; the table gives
  median and 90 % over a sequence's frames. Images are averaged in linear light.
)";

/// The sensors' files of one layout.
const char* SensorsText(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kTum:
      return "- TUM RGB-D layout: `rgb/` with `rgb.txt`, `imu.csv` (gyroscope rad/s, accelerometer m/s^2).";
    case DatasetFormat::kEuroc:
      return "- EuRoC ASL layout: `mav0/cam0`, `mav0/imu0` (gyroscope rad/s, accelerometer m/s^2), each with "
             "`sensor.yaml`.";
    case DatasetFormat::kVslamlab:
      return "- VSLAM-LAB layout: `rgb_0/` with `rgb.csv`, `imu_0.csv` (gyroscope rad/s, accelerometer m/s^2),\n"
             "  `calibration.yaml` as it has it. Its truth is `groundtruth.csv`, beside the folder.";
  }
  GAITCAM_ASSERT(false);
  return "";
}

/// Whose settings lie in each sequence, with the command lines, by the first sequence's calibration.
std::string SettingsText(const fs::path& sequences, const std::vector<SequenceRecord>& records, DatasetFormat format) {
  if (records.empty()) return "";
  const fs::path file = CalibrationFileOf(sequences / records.front().name, format);
  if (!fs::exists(file)) return "";
  return "## Other programs\n\nEach sequence's `settings/` holds its calibration as other programs read it.\n\n```\n" +
         SettingsGuide(ReadCalibration(file), format) + "```\n";
}

constexpr const char* kPairsText =
    R"(- Pairs, `sequences/NAME-truth/pairs/NNNNNN_MMMMMM/`: `a.png`, `b.png` blurred; `a_sharp.png`, `b_sharp.png`;
  `a_blur.png`, `b_blur.png` blur vectors; `H_floor.txt` maps points of the floor from a to b (undistorted pixels, which
  are the image's own if the lens has no distortion); `points.csv` true points: px in a, px in b, m in the world, and
  whether on the floor; `pair.txt` stamps and poses. All at mid-exposure.
)";

/// Nothing if every sequence has its right calibration.
std::string CalibrationErrorText(const RecordMatrix& matrix) {
  const auto& conditions = matrix.experiment.conditions;
  const auto errs = [](const Condition& c) { return !SaysNothing(c.resolved.scenario.calibration_error); };
  if (std::none_of(conditions.begin(), conditions.end(), errs)) return "";
  return "Calibrations and readings are wrong on purpose, as a bench leaves them (`calibration_error` of the "
         "scenario):\n"
         "the truth's folder has the right `calibration.yaml`, and `calibration_error.yaml` says what is wrong.\n\n";
}

}  // namespace

std::string DatasetIndex(const RecordMatrix& matrix, const std::vector<SequenceRecord>& records) {
  const auto by_name = ByName(records);
  std::string text = "name";
  for (const std::string& key : matrix.experiment.keys) text += "," + CsvField(key);
  text += ",seed,frames,duration_s,blur_median_px,blur_p90_px,pairs,status,path,truth_path\n";
  for (const PlannedSequence& sequence : matrix.sequences) {
    const auto it = by_name.find(sequence.name);
    if (it == by_name.end()) continue;
    const SequenceRecord& r = *it->second;
    text += r.name;
    for (const std::string& key : matrix.experiment.keys)
      text += "," + CsvField(LevelOf(matrix.experiment.conditions[sequence.condition], key));
    text += fmt::format(",{},{},{:.3f},{:.3f},{:.3f},{},{},sequences/{},sequences/{}-truth\n", sequence.seed, r.frames,
                        r.end_time_s, r.blur_median_px, r.blur_p90_px, r.pairs, r.status, r.name, r.name);
  }
  return text;
}

std::string DatasetCard(const RecordMatrix& matrix, const std::vector<SequenceRecord>& records, const fs::path& out) {
  const MatrixOptions& o = matrix.options;
  const std::string& name = matrix.experiment.options.name;
  std::string text = "# " + name + "\n\n";
  if (!o.description.empty()) text += o.description + "\n\n";
  text +=
      Summary(matrix, records) + "\n\n" +
      "Synthetic: a humanoid robot walks in physics simulation (MuJoCo) with contacts only; its head camera films a\n"
      "rendered scene. Each image is the average, in linear light, of as many instants of the exposure as its motion\n"
      "needs, with photon and read noise. No people, no places of the real world, no personal data.\n\n" +
      "**Licence:** " + (o.licence.empty() ? "not stated; ask whoever gave you this data" : o.licence) + "\n\n" +
      CalibrationErrorText(matrix) + "## What varies\n\n" + AxesText(matrix) + "\n## Sequences\n\n" +
      SequenceTable(matrix, records) + "\n";
  const DatasetFormat format = o.recording.format;
  text += fmt::format(fmt::runtime(kLayout), fmt::arg("layout", NameOfLayout(format)),
                      fmt::arg("sensors", SensorsText(format)),
                      fmt::arg("calibration", CalibrationFileOf("", format).string()),
                      fmt::arg("times", TimesFileOf("", format).string()),
                      fmt::arg("pairs", o.recording.pairs.enabled ? kPairsText : ""));
  text += "\n" + SettingsText(out / "sequences", records, format);
  text += "\n## Made by\n\n" + VersionsText(records) +
          "\n## To make it again, to check it, to cite it\n\n"
          "`gaitcam record matrix.yaml --out FOLDER" +
          matrix.changes +
          "` makes it again, beside the scenario file that its `base` names;\n"
          "the same program and renderer give the same files, to the byte, but for the films.\n`gaitcam validate "
          "FOLDER` checks files, "
          "tables and geometry.\n\n" +
          fmt::format("Cite as: {}\"{}\", data set made with gaitcam {}.\n", o.author.empty() ? "" : o.author + ", ",
                      name, ProgramVersion());
  return text;
}

void WriteDatasetFiles(const fs::path& out, const RecordMatrix& matrix, const std::vector<SequenceRecord>& records) {
  WriteWholeFile(out / "index.csv", DatasetIndex(matrix, records));
  WriteWholeFile(out / "README.md", DatasetCard(matrix, records, out));
  std::string sums;
  for (const char* name : {"README.md", "index.csv", "matrix.yaml"})
    sums += Sha256OfFile(out / name) + "  " + name + "\n";
  for (const SequenceRecord& r : records) {
    const fs::path file = SumsOf(out / "sequences", r.name);
    std::istringstream stream(FileContent(file));
    for (std::string row; std::getline(stream, row);) sums += row.substr(0, 66) + "sequences/" + row.substr(66) + "\n";
    sums += Sha256OfFile(file) + "  sequences/" + r.name + "-truth/" + file.filename().string() + "\n";
  }
  WriteWholeFile(out / "SHA256SUMS", sums);
}

}  // namespace gaitcam
