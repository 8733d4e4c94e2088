/// Eight floats at once, on processors that can.

#pragma once

/// Stands before the definition of a function that spends its time in sums over vectors of eight floats (GCC's
/// vector_size). The x86-64 baseline computes such a vector as two halves, AVX (all processors since 2013) as one: the
/// function is compiled for both, and the loader chooses. Neither fuses a product and a sum, so that both give the same
/// bits. ThreadSanitizer's run-time library is not yet ready when the loader chooses; clang refuses such vectors where
/// both versions call for them.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
#define GAITCAM_AVX_CLONES [[gnu::target_clones("avx", "default")]]
#else
#define GAITCAM_AVX_CLONES
#endif
