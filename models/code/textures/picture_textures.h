/// Pictures for posters: content with the statistics of natural images. They do not wrap around.

#pragma once

#include <opencv2/core.hpp>

#include "algorithms/core/random.h"
#include "models/code/textures/texture.h"

namespace gaitcam {

/// Opaque discs that hide each other, radii with density r^-3 from 1.5 px to `unit_m`: the occlusions, scale invariance
/// and 1/f amplitude spectrum of natural images (Lee, Mumford and Huang, "Occlusion models for natural images", 2001).
cv::Mat MakeDeadLeaves(const TextureOptions& options, cv::Size size, RandomStream& random);

/// Clouds with the 1/f amplitude spectrum of natural images in brightness and, weaker, in colour.
cv::Mat MakePink(const TextureOptions& options, cv::Size size, RandomStream& random);

/// A printed poster: headline, photographs (dead leaves), plots and paragraphs in columns, perhaps a frame.
cv::Mat MakePoster(const TextureOptions& options, cv::Size size, RandomStream& random);

/// A cork board with sheets pinned to it.
cv::Mat MakeNoticeBoard(const TextureOptions& options, cv::Size size, RandomStream& random);

}  // namespace gaitcam
