#pragma once

#include <map>
#include <utility>
#include <vector>

namespace hymm::core {

/// A rectangle of pixels on one of the pages of an atlas.
struct AtlasPlace {
  int page = -1;
  int x = 0, y = 0;           ///< of its first pixel
  int width = 0, height = 0;  ///< asked for
};

/// Finds places for many small images on few square pages, so that thousands of them are drawn at
/// once. Images stand on shelves of their height; a place that is given back goes to the next image
/// of about its size.
class TextureAtlas {
 public:
  explicit TextureAtlas(int page_size) : page_size_(page_size) {}

  int pages() const { return static_cast<int>(pages_.size()); }

  /// Throws std::length_error if the image is larger than a page or has no pixels.
  AtlasPlace place(int width, int height);
  void giveBack(const AtlasPlace& place);
  void clear();

 private:
  struct Shelf {
    int y, height, used;  ///< `used` of the page's width
  };
  struct Page {
    std::vector<Shelf> shelves;
    int used = 0;  ///< of its height
  };
  using Size = std::pair<int, int>;

  Size roundedUp(int width, int height) const;

  int page_size_;
  std::vector<Page> pages_;
  std::map<Size, std::vector<AtlasPlace>> free_;
};

}  // namespace hymm::core
