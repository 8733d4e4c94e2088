// What sanitizers are told of libraries that are not built with them; a part of each program of such a build. In a
// file, programs in a sandbox would not find it.

/// liburdfdom's links and their parents hold each other, and are never given back.
extern "C" const char* __lsan_default_suppressions() { return "leak:liburdfdom_model\n"; }

/// OpenCV counts the users of an image where the sanitizer cannot see it; what its threads have made, in its room for
/// each thread, in key points or in images, is freed by ours; and the first thread makes what all evaluate expressions
/// of images with. Mesa's software renderer and FFmpeg's encoder hand over what they share unseen, too. GDAL takes two
/// locks in either order.
extern "C" const char* __tsan_default_suppressions() {
  return "race:cv::Mat::deallocate\n"
         "race:cv::Mat::release\n"
         "race:cv::MatExpr::operator cv::Mat\n"
         "race:cv::TLSDataContainer::release\n"
         "race:libopencv_features2d.so\n"
         "race:libopencv_imgproc.so\n"
         "race:libavutil.so\n"
         "called_from_lib:libopencv_imgcodecs.so\n"
         "race:swrast_dri.so\n"
         "deadlock:libgdal.so\n";
}
