/// How a recorded walk lies on disk. What a SLAM system may see, and the truth, are two folders side by side:
///
///   OUT/NAME/            the sensors: the only folder that a SLAM system is given
///   OUT/NAME-truth/      what the simulator knows, under the names that the layout gives to ground truth
///
/// Each layout is read unchanged by tools made for it. Files of ours beside the layout's own:
///
///   calibration.yaml     cameras, extrinsics, IMU noise, as the system was told them (calibration_file.h); where
///                        the layout has a calibration.yaml of its own (vslamlab), calibration_gaitcam.yaml
///   settings/            the same calibration as other programs read it (program_settings.h)
///   exposure.csv         stamp_ns, exposure_ms, and how many samples of imu.csv, joints.csv and, if it is
///                        there, odometry.csv belong to the frame
///   joints.csv           stamp_ns and readings; numbers as short as they come back exactly
///   odometry.csv         stamp_ns and where the body has come to as it reckons, if it does: x m, y m, heading rad
///   about.txt            what the folder holds, which frames and instants its numbers mean, how the recording
///                        ended, and the command line of each program that there are settings for
///
/// The layouts:
///
///   tum                  rgb/ rgb.txt [depth/ depth.txt associations.txt] [rgb_right/ rgb_right.txt]
///                        [imu.csv accelerometer.txt] times.txt
///   euroc                mav0/{cam0,cam1,depth0}/{data/,data.csv,sensor.yaml} mav0/imu0/{data.csv,sensor.yaml}
///                        mav0/cam0/times.txt
///   vslamlab             rgb_0/ [rgb_1/] [depth_0/] rgb.csv [imu_0.csv] calibration.yaml times.txt
///
/// times.txt is "id t_s exposure_ms" per frame; it lies beside the folder of images, where direct odometry looks for
/// it. TUM's tables of images and poses begin with three lines of comment, which its readers skip; associations.txt and
/// times.txt with none.
///
/// Depth PNGs hold 16 bits, 5000 per metre, 0 where nothing was measured. Where a measured depth image does not fit
/// them exactly (further than 13.1 m, or not a multiple of 0.2 mm), a lossless twin lies in depth_exact/STAMP_NS.tiff;
/// of true depth, only where it reaches further than 13.1 m.
///
/// Truth of every layout:
///
///   groundtruth.txt      TUM format, X_WC of the left camera at mid-exposure
///   frames.csv           poses at shutter open and close, blur of the image, gait phase, foot contacts, root pose
///   subposes.csv         every sub-frame: its frame's stamp, its own, weight, X_WC
///   sharp/ sharp.txt     sharp twin
///   depth/ depth.txt     depth
///   blur/ blur.txt       blur vectors as 16-bit PNG in the way that KITTI stores optical flow: red and green hold
///                        64 x + 2^15, blue 1 where the vector is known
///   calibration.yaml     the right one, where the sensors' folder has a wrong one on purpose
///   calibration_error.yaml   what is wrong with calibration and readings there
///   mav0/state_groundtruth_estimate0/{data.csv,sensor.yaml}   (euroc) pose of the body, which is the IMU
///   groundtruth.csv      (vslamlab) the poses of groundtruth.txt
///
/// Stamps are nanoseconds on one clock, images are stamped at mid-exposure. The simulator's clock has ten digits of
/// seconds (kClockStart_ns), so that names of images sort by time.

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "algorithms/core/enum_words.h"

namespace gaitcam {

enum class DatasetFormat { kTum, kEuroc, kVslamlab };
constexpr auto WordsOf(DatasetFormat) {
  return std::array{EnumWord{DatasetFormat::kTum, "tum"}, EnumWord{DatasetFormat::kEuroc, "euroc"},
                    EnumWord{DatasetFormat::kVslamlab, "vslamlab"}};
}

/// "tum", "euroc", "vslamlab".
std::string ToString(DatasetFormat format);
/// "TUM RGB-D layout", "EuRoC ASL layout", "VSLAM-LAB layout".
std::string NameOfLayout(DatasetFormat format);
/// @throws BadInput naming the unknown word and the known ones.
DatasetFormat DatasetFormatFromText(const std::string& text);

enum class ImageStream { kLeft, kRight, kDepth };

/// Where the images of one stream lie, and the table that lists them.
struct ImageListing {
  std::filesystem::path folder;  ///< Of the images.
  std::filesystem::path base;    ///< What the names in the table are relative to.
  std::filesystem::path table;
  char separator = ',';     ///< As of TextTable.
  bool in_seconds = false;  ///< Stamps with nine decimals, in the table and as names; else whole nanoseconds.
  /// Names of the columns of stamp and file, where the table's first row names its columns; else they are the first
  /// two.
  std::string stamp_column, file_column;

  bool names_columns() const { return !stamp_column.empty(); }
  /// "1700000000.010000000.png" or "1700000000010000000.png".
  std::string FileName(int64_t stamp_ns) const;
};

/// @param dataset a dataset of sensors in this layout; the stream need not be there.
ImageListing ListingOf(const std::filesystem::path& dataset, DatasetFormat format, ImageStream stream);
/// NAME/ and NAME.txt as in TUM's layout: so lie the images of the truth, "sharp", "depth", "blur".
ImageListing TumListing(const std::filesystem::path& root, const std::string& name);

/// Our own calibration file; where the folder is by others, it need not be there.
std::filesystem::path CalibrationFileOf(const std::filesystem::path& dataset, DatasetFormat format);
/// Times and exposures of the frames.
std::filesystem::path TimesFileOf(const std::filesystem::path& dataset, DatasetFormat format);
/// Samples of the IMU; VSLAM-LAB's table names its columns in the first row.
std::filesystem::path ImuFileOf(const std::filesystem::path& dataset, DatasetFormat format);

/// The folder of the sensors and that of the truth of one recording.
struct DatasetFolders {
  std::filesystem::path sensors, truth;

  /// OUT/NAME and OUT/NAME-truth.
  static DatasetFolders In(const std::filesystem::path& out, const std::string& name);
};

/// The right calibration, where the sensors' folder has a wrong one on purpose; else there is no such file.
std::filesystem::path TrueCalibrationFileOf(const DatasetFolders& folders);
/// That file if it is there, else the sensors' own.
std::filesystem::path RightCalibrationFileOf(const DatasetFolders& folders, DatasetFormat format);

/// @returns `folder` if it is a dataset of sensors, or the only one that lies directly in it.
/// @throws BadInput if there is none, or more than one.
std::filesystem::path FindDataset(const std::filesystem::path& folder);

/// The format of a folder, told by the files in it. @throws BadInput if it is none of them.
DatasetFormat FormatOfDataset(const std::filesystem::path& folder);

}  // namespace gaitcam
