/// std::popcount as one instruction, on processors that have it.

#pragma once

/// Stands before the definition of a function that spends its time in std::popcount. The x86-64 baseline lacks the
/// POPCNT instruction, which all processors since 2008 have: the function is compiled with and without it, and the
/// loader chooses. Without, a query of a WaveletMap takes 4.4 times as long (tests/benchmarks/place_benchmark.cpp);
/// with cv::hal::normHamming, which is dispatched at each call, a comparison of 24 to 48 bytes takes 5 times as long.
/// ThreadSanitizer's run-time library is not yet ready when the loader chooses.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_THREAD__)
#define GAITCAM_POPCNT_CLONES [[gnu::target_clones("popcnt", "default")]]
#else
#define GAITCAM_POPCNT_CLONES
#endif
