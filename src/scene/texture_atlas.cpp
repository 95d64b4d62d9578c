#include "scene/texture_atlas.h"

#include <algorithm>
#include <stdexcept>

namespace hymm::core {
namespace {

// Images of nearly the same size share shelves, and places that others gave back.
constexpr int kStep = 8;

}  // namespace

TextureAtlas::Size TextureAtlas::roundedUp(int width, int height) const {
  const auto round = [&](int size) {
    return std::min(page_size_, (size + kStep - 1) / kStep * kStep);
  };
  return {round(width), round(height)};
}

AtlasPlace TextureAtlas::place(int width, int height) {
  if (width < 1 || height < 1 || width > page_size_ || height > page_size_) {
    throw std::length_error("An image has no place on a page of the atlas.");
  }
  const Size size = roundedUp(width, height);
  if (std::vector<AtlasPlace>& free = free_[size]; !free.empty()) {
    AtlasPlace place = free.back();
    free.pop_back();
    place.width = width;
    place.height = height;
    return place;
  }
  for (int number = 0;; ++number) {
    if (number == pages()) pages_.emplace_back();
    Page& page = pages_[std::size_t(number)];
    for (Shelf& shelf : page.shelves) {
      if (shelf.height != size.second || shelf.used + size.first > page_size_) continue;
      const AtlasPlace place = {number, shelf.used, shelf.y, width, height};
      shelf.used += size.first;
      return place;
    }
    if (page.used + size.second > page_size_) continue;
    page.shelves.push_back({page.used, size.second, size.first});
    page.used += size.second;
    return {number, 0, page.shelves.back().y, width, height};
  }
}

void TextureAtlas::giveBack(const AtlasPlace& place) {
  free_[roundedUp(place.width, place.height)].push_back(place);
}

void TextureAtlas::clear() {
  pages_.clear();
  free_.clear();
}

}  // namespace hymm::core
