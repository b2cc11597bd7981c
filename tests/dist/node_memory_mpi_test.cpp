#include "noiseloom/dist/node_memory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

namespace noiseloom {
namespace {

SharedValues<std::uint64_t> numbers_up_to(const Communicator& world, std::size_t count, std::int64_t& fillers) {
  NodeMemory memory(world, count * sizeof(std::uint64_t));
  const std::span<std::byte> bytes = memory.to_fill();
  EXPECT_TRUE(bytes.empty() || bytes.size() == count * sizeof(std::uint64_t));
  auto* const numbers = reinterpret_cast<std::uint64_t*>(bytes.data());
  if (!bytes.empty()) {
    for (std::size_t i = 0; i < count; ++i) numbers[i] = i;
  }
  std::array<std::int64_t, 1> all = {bytes.empty() ? 0 : 1};
  world.sum(all);
  fillers = all[0];
  return memory.filled<std::uint64_t>();
}

std::set<std::string> names_of_blocks() {
  std::set<std::string> names;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm", none)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("noiseloom-node-")) names.insert(name);
  }
  return names;
}

TEST(NodeMemory, IsFilledByOneRankOfANodeAndReadByAll) {
  const Communicator world = Communicator::world();
  const std::set<std::string> before = names_of_blocks();
  world.barrier();
  std::int64_t fillers = 0;
  const SharedValues<std::uint64_t> numbers = numbers_up_to(world, 100'000, fillers);
  ASSERT_EQ(numbers.size(), 100'000U);
  for (std::size_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], i);
  const bool one_node = world.ranks_on_node() == world.size();
  std::error_code none;
  const bool shares = std::filesystem::space("/dev/shm", none).available > 1'000'000 && access("/dev/shm", W_OK) == 0;
  if (one_node && shares) {
    EXPECT_EQ(fillers, 1);
  }
  world.barrier();
  // Nothing stays behind that would outlive the run. Other runs' names stand there for an instant.
  const auto is_left = [&] {
    const std::set<std::string> now = names_of_blocks();
    return !std::includes(before.begin(), before.end(), now.begin(), now.end());
  };
  for (int tries = 0; is_left() && tries < 100; ++tries) usleep(50'000);
  EXPECT_FALSE(is_left());
}

TEST(NodeMemory, LivesAsLongAsItsValuesAndMayBeEmpty) {
  const Communicator world = Communicator::world();
  std::int64_t fillers = 0;
  SharedValues<std::uint64_t> kept;
  for (const std::size_t count : {3U, 0U, 70'000U}) {
    const SharedValues<std::uint64_t> numbers = numbers_up_to(world, count, fillers);
    EXPECT_EQ(numbers.size(), count);
    if (count == 3) kept = numbers;
  }
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept[2], 2U);
}

}  // namespace
}  // namespace noiseloom
