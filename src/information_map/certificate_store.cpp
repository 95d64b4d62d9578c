#include "information_map/certificate_store.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hymm::core {
namespace {

// Elsewhere in a tile, log i may change this many times as much as at its sample.
constexpr float kSampleSafety = 2.0F;

}  // namespace

void CertificateStore::resize(int tiles) {
  while (size() < tiles) tiles_.push_back(std::make_unique<Tile>());
}

void CertificateStore::certify(int tile, int cell, const AchievableInformation& information,
                               double slack) {
  Tile& held = this->tile(tile);
  Certificate& certificate = held.certificates[std::size_t(cell)];
  certificate.value = static_cast<float>(information.value);
  certificate.slack = static_cast<float>(slack);
  certificate.margin_m = std::max(least_margin_m_, static_cast<float>(information.margin_m));
  certificate.moved_at = held.moved_m;
  certificate.changed_at = held.changed;
  certificate.landmarks = information.landmarks;
}

void CertificateStore::beginChange(float let_go_m) {
  for (auto& tile : tiles_) {
    tile->is_touched = false;
    tile->lets_go = tile->moved_m - tile->settled_at > let_go_m;
    if (tile->lets_go) tile->settled_at = tile->moved_m;
  }
}

void CertificateStore::addChange(int tile, float moved_m, float changed) {
  Tile& held = this->tile(tile);
  held.moved_m += moved_m;
  // Geometry counts like covariance: a landmark that moved is measured along another line.
  held.unsampled += changed + moved_m;
}

bool CertificateStore::addSample(int tile, int cell, const Certificate& before) {
  Tile& held = this->tile(tile);
  Certificate& now = held.certificates[std::size_t(cell)];
  if (now.landmarks != before.landmarks || !(now.value > 0.0F) || !(before.value > 0.0F)) {
    return false;
  }
  held.changed += kSampleSafety * std::abs(std::log(now.value / before.value));
  now.changed_at = held.changed;
  return true;
}

void CertificateStore::revokeAll(int tile) {
  for (Certificate& certificate : this->tile(tile).certificates) certificate.landmarks = -1;
}

std::array<int, CertificateStore::kMostSamples> CertificateStore::tightest(int tile) const {
  const auto& certificates = this->tile(tile).certificates;
  std::array<int, kMostSamples> best;
  best.fill(-1);
  for (int i = 0; i < LevelLattice::kTileCells; ++i) {
    const Certificate& certificate = certificates[std::size_t(i)];
    if (certificate.landmarks < 0 || certificate.slack == Certificate::kUnlimited) continue;
    int candidate = i;
    for (int& kept : best) {
      if (kept < 0) {
        kept = candidate;
        break;
      }
      if (certificates[std::size_t(candidate)].slack < certificates[std::size_t(kept)].slack) {
        std::swap(candidate, kept);
      }
    }
  }
  return best;
}

}  // namespace hymm::core
