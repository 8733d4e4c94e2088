#include "algorithms/io/writer_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "algorithms/core/errors.h"

namespace gaitcam {
namespace {

TEST(WriterPool, DoesEveryJobByTheTimeItFinishes) {
  for (const int threads : {0, 1, 3}) {
    std::atomic<int> sum = 0;
    WriterPool pool(threads);
    for (int i = 1; i <= 500; ++i) pool.Do([&sum, i] { sum += i; });
    pool.Finish();
    EXPECT_EQ(sum, 125250) << threads;
  }
}

TEST(WriterPool, ItsProducerWaitsSoThatFewJobsAreInMemory) {
  std::atomic<int> begun = 0;
  std::atomic<bool> go = false;
  WriterPool pool(1);
  std::thread producer([&] {
    for (int i = 0; i < 100; ++i) {
      pool.Do([&go] {
        while (!go) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      });
      ++begun;
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LE(begun, WriterPool::kWaitingPerThread + 1);  // those that wait, and the one at work
  go = true;
  producer.join();
  pool.Finish();
  EXPECT_EQ(begun, 100);
}

TEST(WriterPool, AFailureReachesTheProducerAndStopsTheRest) {
  for (const int threads : {0, 2}) {
    std::atomic<int> done = 0;
    WriterPool pool(threads);
    EXPECT_THROW(
        {
          pool.Do([] { throw MissingResource("the disk is full"); });
          for (int i = 0; i < 1000; ++i) pool.Do([&done] { ++done; });
          pool.Finish();
        },
        MissingResource);
    EXPECT_LT(done, 1000) << threads;
  }
}

TEST(WriterPool, AbandonedItDropsWhatWaits) {
  std::atomic<int> done = 0;
  {
    WriterPool pool(1);
    for (int i = 0; i < 8; ++i) {
      pool.Do([&done] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        ++done;
      });
    }
  }
  EXPECT_LT(done, 8);
}

}  // namespace
}  // namespace gaitcam
