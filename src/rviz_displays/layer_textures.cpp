#include "rviz_displays/layer_textures.h"

#include <chrono>

#include <OgreHardwarePixelBuffer.h>
#include <OgreMaterialManager.h>
#include <OgrePixelFormat.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>

#include "rviz_displays/mesh_object.h"

namespace hymm {
namespace {

constexpr unsigned char kSeeThrough = 10;  ///< of 255: what is more transparent has no depth either

}  // namespace

LayerTextures::~LayerTextures() { clear(); }

void LayerTextures::take(int ltr, const std::string& layer, core::LayerField field) {
  const bool chosen = layer == chosen_;
  core::LayerField& kept = fields_[layer][ltr];
  kept = std::move(field);
  if (!chosen) return;
  if (seen_range_.include(kept) && !fixed_range_) {
    repaintAll();
  } else {
    to_paint_.insert(ltr);
  }
}

void LayerTextures::remove(int ltr) {
  for (auto& [layer, fields] : fields_) fields.erase(ltr);
  forget(ltr);
}

void LayerTextures::forget(int ltr) {
  to_paint_.erase(ltr);
  const auto place = places_.find(ltr);
  if (place == places_.end()) return;
  atlas_.giveBack(place->second);
  places_.erase(place);
  ++revision_;
}

void LayerTextures::clear() {
  fields_.clear();
  to_paint_.clear();
  places_.clear();
  atlas_.clear();
  for (const Page& page : pages_) {
    Ogre::MaterialManager::getSingleton().remove(page.material);
    Ogre::TextureManager::getSingleton().remove(page.texture);
  }
  pages_.clear();
  seen_range_ = {};
  ++revision_;
}

void LayerTextures::choose(const std::string& layer) {
  if (layer == chosen_) return;
  chosen_ = layer;
  std::map<int, core::AtlasPlace> before;
  before.swap(places_);
  for (const auto& [ltr, place] : before) atlas_.giveBack(place);
  ++revision_;
  seen_range_ = {};
  to_paint_.clear();
  const auto fields = fields_.find(chosen_);
  if (fields == fields_.end()) return;
  for (const auto& [ltr, field] : fields->second) seen_range_.include(field);
  repaintAll();
}

void LayerTextures::setRange(const std::optional<core::ValueRange>& range) {
  fixed_range_ = range;
  repaintAll();
}

void LayerTextures::repaintAll() {
  const auto fields = fields_.find(chosen_);
  if (fields == fields_.end()) return;
  for (const auto& [ltr, field] : fields->second) to_paint_.insert(ltr);
}

bool LayerTextures::paintSome(double longest_s) {
  using Clock = std::chrono::steady_clock;
  if (to_paint_.empty()) return false;
  const Clock::time_point begin = Clock::now();
  const auto& fields = fields_[chosen_];
  while (!to_paint_.empty()) {
    const int ltr = *to_paint_.begin();
    to_paint_.erase(to_paint_.begin());
    const auto field = fields.find(ltr);
    if (field != fields.end()) paint(ltr, field->second);
    if (std::chrono::duration<double>(Clock::now() - begin).count() > longest_s) break;
  }
  return true;
}

void LayerTextures::paint(int ltr, const core::LayerField& field) {
  core::LayerImage image = core::paint(field, range());
  auto place = places_.find(ltr);
  if (place != places_.end() &&
      (place->second.width != image.width || place->second.height != image.height)) {
    forget(ltr);
    place = places_.end();
  }
  if (place == places_.end()) {
    place = places_.emplace(ltr, atlas_.place(image.width, image.height)).first;
    while (pages() < atlas_.pages()) addPage();
    ++revision_;
  }
  const auto width = static_cast<Ogre::uint32>(image.width);
  const auto height = static_cast<Ogre::uint32>(image.height);
  const auto x = static_cast<Ogre::uint32>(place->second.x);
  const auto y = static_cast<Ogre::uint32>(place->second.y);
  const Ogre::PixelBox pixels(width, height, 1, Ogre::PF_BYTE_RGBA, image.pixels.data());
  pages_[std::size_t(place->second.page)].texture->getBuffer()->blitFromMemory(
      pixels, Ogre::Box(x, y, x + width, y + height));
}

void LayerTextures::addPage() {
  static int count = 0;
  Page page;
  page.texture = Ogre::TextureManager::getSingleton().createManual(
      "hymm layer page " + std::to_string(count++),
      Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME, Ogre::TEX_TYPE_2D, kPageSize,
      kPageSize, 0, Ogre::PF_BYTE_RGBA, Ogre::TU_DEFAULT);
  page.material = makeFlatMaterial();
  Ogre::Pass* pass = page.material->getTechnique(0)->getPass(0);
  Ogre::TextureUnitState* unit = pass->createTextureUnitState();
  unit->setTexture(page.texture);
  unit->setTextureFiltering(Ogre::TFO_NONE);  // a cell is a cell
  unit->setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
  applyAlpha(page);
  pages_.push_back(page);
}

void LayerTextures::setAlpha(float alpha) {
  alpha_ = alpha;
  for (const Page& page : pages_) applyAlpha(page);
}

void LayerTextures::applyAlpha(const Page& page) const {
  Ogre::Pass* pass = page.material->getTechnique(0)->getPass(0);
  pass->getTextureUnitState(0)->setAlphaOperation(Ogre::LBX_MODULATE, Ogre::LBS_TEXTURE,
                                                  Ogre::LBS_MANUAL, 1.0F, alpha_);
  pass->setAlphaRejectSettings(Ogre::CMPF_GREATER, kSeeThrough);
  // What is solid hides what is below it; else all of it shines through.
  pass->setDepthWriteEnabled(alpha_ > 0.99F);
}

const core::AtlasPlace* LayerTextures::find(int ltr) const {
  const auto place = places_.find(ltr);
  return place == places_.end() ? nullptr : &place->second;
}

std::set<std::string> LayerTextures::layers() const {
  std::set<std::string> names;
  for (const auto& [layer, fields] : fields_) names.insert(layer);
  return names;
}

}  // namespace hymm
