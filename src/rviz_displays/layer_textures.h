#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <OgreMaterial.h>
#include <OgreTexture.h>

#include "scene/layer_image.h"
#include "scene/texture_atlas.h"

namespace hymm {

/// Layers of LTRs, and the chosen one of them as textures on few large pages. Where the LTRs lie
/// has no part in it.
class LayerTextures {
 public:
  static constexpr int kPageSize = 2048;

  LayerTextures() : atlas_(kPageSize) {}
  ~LayerTextures();
  LayerTextures(const LayerTextures&) = delete;
  LayerTextures& operator=(const LayerTextures&) = delete;

  void take(int ltr, const std::string& layer, core::LayerField field);
  /// Forgets all layers of a retired LTR.
  void remove(int ltr);
  void clear();

  /// An empty name shows none.
  void choose(const std::string& layer);
  /// Of values; nothing: as they come.
  void setRange(const std::optional<core::ValueRange>& range);
  void setAlpha(float alpha);

  /// Paints what changed, for so long at most. Returns whether anything was painted.
  bool paintSome(double longest_s);

  /// Where the chosen layer of an LTR is painted, if it is.
  const core::AtlasPlace* find(int ltr) const;
  int pages() const { return static_cast<int>(pages_.size()); }
  const Ogre::MaterialPtr& material(int page) const { return pages_[std::size_t(page)].material; }

  std::set<std::string> layers() const;
  std::size_t painted() const { return places_.size(); }
  const core::ValueRange& range() const { return fixed_range_ ? *fixed_range_ : seen_range_; }
  /// Grows when a place was given or taken: texture coordinates are then no longer the same.
  std::uint64_t revision() const { return revision_; }

 private:
  struct Page {
    Ogre::TexturePtr texture;
    Ogre::MaterialPtr material;
  };

  void paint(int ltr, const core::LayerField& field);
  void addPage();
  void applyAlpha(const Page& page) const;
  void repaintAll();
  /// Gives its place on the pages back.
  void forget(int ltr);

  std::string chosen_;
  std::map<std::string, std::map<int, core::LayerField>> fields_;  ///< by layer and LTR
  std::set<int> to_paint_;
  core::TextureAtlas atlas_;
  std::map<int, core::AtlasPlace> places_;
  std::vector<Page> pages_;
  std::optional<core::ValueRange> fixed_range_;
  core::ValueRange seen_range_;
  float alpha_ = 1.0F;
  std::uint64_t revision_ = 0;
};

}  // namespace hymm
