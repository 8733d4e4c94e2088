#include "algorithms/core/bounded_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace gaitcam {
namespace {

TEST(BoundedQueue, KeepsOrderAndEveryItemUnderAFasterProducer) {
  BoundedQueue<int> queue(3);
  std::thread producer([&] {
    for (int i = 0; i < 10000; ++i) ASSERT_TRUE(queue.Push(i));
    queue.Close();
  });
  int expected = 0;
  while (const auto item = queue.Pop()) ASSERT_EQ(*item, expected++);
  producer.join();
  EXPECT_EQ(expected, 10000);
}

TEST(BoundedQueue, NeverHoldsMoreThanItsCapacity) {
  BoundedQueue<int> queue(2);
  std::atomic<int> pushed = 0;
  std::thread producer([&] {
    for (int i = 0; i < 5; ++i) {
      queue.Push(i);
      ++pushed;
    }
  });
  while (pushed < 2) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(pushed, 2);  // the third waits for room
  for (int i = 0; i < 5; ++i) EXPECT_EQ(*queue.Pop(), i);
  producer.join();
}

TEST(BoundedQueue, ClosingFreesAWaitingProducer) {
  BoundedQueue<int> queue(1);
  ASSERT_TRUE(queue.Push(1));
  std::thread producer([&] { EXPECT_FALSE(queue.Push(2)); });
  queue.Close();
  producer.join();
  EXPECT_EQ(*queue.Pop(), 1);
  EXPECT_FALSE(queue.Pop());
}

}  // namespace
}  // namespace gaitcam
