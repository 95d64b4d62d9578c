#include <gtest/gtest.h>

#include "fuzz/harness.h"

namespace hymm::test {
namespace {

// FUZZER is the name of the one that is built in.
constexpr std::size_t kMostPlaces = 60;  // in a seed: the fuzzers themselves look everywhere

bool reads(const std::string& input) {
  return isRead(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

/// Does `spoil` at places all over each seed: what comes of it is read or refused in a sentence.
template <class Spoil>
void expectNoFindings(Spoil spoil) {
  for (const auto& [name, seed] : seeds()) {
    const std::size_t step = seed.size() / kMostPlaces + 1;
    for (std::size_t place = 0; place < seed.size(); place += step) {
      EXPECT_NO_THROW(reads(spoil(seed, place))) << name << ", at byte " << place;
    }
  }
}

TEST(FUZZER, ReadsItsSeeds) {
  ASSERT_FALSE(seeds().empty());
  for (const auto& [name, seed] : seeds()) EXPECT_TRUE(reads(seed)) << name;
}

TEST(FUZZER, HasNoFindingInNothingNorInZeros) {
  EXPECT_NO_THROW(reads(std::string()));
  EXPECT_NO_THROW(reads(std::string(1000, '\0')));
}

TEST(FUZZER, HasNoFindingInSeedsThatAreCutOff) {
  expectNoFindings(
      [](const std::string& seed, std::size_t place) { return seed.substr(0, place); });
}

TEST(FUZZER, HasNoFindingInSeedsWithAByteWrong) {
  expectNoFindings([](std::string seed, std::size_t place) {
    seed[place] = static_cast<char>(~seed[place]);
    return seed;
  });
}

}  // namespace
}  // namespace hymm::test
