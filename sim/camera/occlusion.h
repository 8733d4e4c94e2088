/// How wrong sub-frames that are computed from a key picture may be at depth edges.
///
/// A pixel takes the depth that the key picture has there. Where two surfaces meet, one has covered or uncovered a
/// strip of the other by the time of the sub-frame, as wide as they have moved against each other; in it the light is
/// wrong by at most the contrast of the two. Averaged over the exposure, an edge that passes L pixels leaves an error
/// of contrast x strip / L in each of them.

#pragma once

#include <opencv2/core.hpp>

#include "sim/camera/key_picture.h"

namespace gaitcam {

/// Over all pixels of an image, in grey levels of 255.
struct GreyError {
  double rms = 0;
  double p99_9 = 0;  ///< A thousandth of all pixels is worse.
};

/// Of an exposure from `open` to `close` whose sub-frames are all computed from one key picture between them. K key
/// pictures, each for a K-th of the exposure, leave a K-th of it.
/// @param rays CV_32FC2; @param depth CV_32FC1, m, at the key's time, both by the image's pixels.
GreyError OcclusionError(const KeyPicture& key, const cv::Mat& rays, const cv::Mat& depth, const SceneInstant& open,
                         const SceneInstant& close);

}  // namespace gaitcam
