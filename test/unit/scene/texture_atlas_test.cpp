#include "scene/texture_atlas.h"

#include <random>
#include <stdexcept>

#include <gmock/gmock.h>

namespace hymm::core {
namespace {

bool overlapping(const AtlasPlace& a, const AtlasPlace& b) {
  return a.page == b.page && a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height &&
         b.y < a.y + a.height;
}

TEST(TextureAtlas, GivesPlacesThatNeverOverlap) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> size(1, 90);
  TextureAtlas atlas(256);
  std::vector<AtlasPlace> places;
  for (int i = 0; i < 400; ++i) {
    if (i % 3 == 2) {
      atlas.giveBack(places.front());
      places.erase(places.begin());
    }
    places.push_back(atlas.place(size(random), size(random)));
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_LE(places[i].x + places[i].width, 256);
    EXPECT_LE(places[i].y + places[i].height, 256);
    for (std::size_t j = 0; j < i; ++j) ASSERT_FALSE(overlapping(places[i], places[j]));
  }
}

TEST(TextureAtlas, TakesAPlaceThatWasGivenBack) {
  TextureAtlas atlas(64);
  const AtlasPlace place = atlas.place(60, 60);
  atlas.giveBack(place);
  EXPECT_EQ(atlas.place(59, 61).page, place.page);
  EXPECT_EQ(atlas.pages(), 1);
}

TEST(TextureAtlas, BeginsAPageWhenOneIsFull) {
  TextureAtlas atlas(64);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(atlas.place(32, 32).page, 0);
  EXPECT_EQ(atlas.place(32, 32).page, 1);
}

TEST(TextureAtlas, RefusesWhatNoPageHolds) {
  TextureAtlas atlas(64);
  EXPECT_THROW(atlas.place(65, 2), std::length_error);
  EXPECT_THROW(atlas.place(0, 2), std::length_error);
}

}  // namespace
}  // namespace hymm::core
