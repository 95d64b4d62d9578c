// The registry and its spatial index against a plain list, over random histories.

#include <algorithm>
#include <map>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "cekf/landmark_index.h"
#include "cekf/landmark_registry.h"
#include "support/any.h"

namespace hymm::core {
namespace {

using Eigen::Vector2d;
using test::anyInteger;

double anyCoordinate() { return anyInteger(-4000, 4001) * 0.01; }
Vector2d anyPlace() {
  const double x = anyCoordinate();
  return {x, anyCoordinate()};
}

struct Listed {
  int slot = -1;
  int identity = -1;
  Vector2d position = Vector2d::Zero();
};

/// A registry after a random history, and the list it should equal, by id. Slots are used again.
class RegistryAndList {
 public:
  RegistryAndList() {
    const int steps = anyInteger(1, 120);
    for (int i = 0; i < steps; ++i) step();
  }

  LandmarkRegistry registry;
  std::map<int, Listed> list;

 private:
  void step() {
    const int dice = anyInteger(0, 10);
    if (dice < 5 || list.empty()) return add();
    const auto index = anyInteger<std::size_t>(0, list.size());
    const auto chosen = std::next(list.begin(), static_cast<std::ptrdiff_t>(index));
    if (dice < 8) {
      chosen->second.position = anyPlace();
      registry.move(registry.byId(chosen->first), chosen->second.position);
    } else {
      registry.remove(chosen->first);
      free_slots_.push_back(chosen->second.slot);
      list.erase(chosen);
    }
  }

  void add() {
    RegisteredLandmark landmark;
    landmark.id = next_id_++;
    landmark.identity = *rc::gen::arbitrary<bool>() ? 1000 + landmark.id : -1;
    landmark.slot = static_cast<int>(list.size() + free_slots_.size());
    if (!free_slots_.empty()) {
      landmark.slot = free_slots_.back();
      free_slots_.pop_back();
    }
    landmark.position = anyPlace();
    registry.add(landmark);
    list[landmark.id] = {landmark.slot, landmark.identity, landmark.position};
  }

  std::vector<int> free_slots_;
  int next_id_ = 0;
};

RC_GTEST_PROP(LandmarkRegistry, FindsWhatAPlainListFinds, ()) {
  RegistryAndList both;
  RC_ASSERT(both.registry.size() == both.list.size());
  for (const auto& [id, listed] : both.list) {
    RC_ASSERT(both.registry.byId(id).slot == listed.slot);
    RC_ASSERT(both.registry.bySlot(listed.slot).id == id);
    RC_ASSERT(both.registry.byId(id).position == listed.position);
    if (listed.identity < 0) continue;
    const RegisteredLandmark* found = both.registry.findIdentity(listed.identity);
    RC_ASSERT(found != nullptr);
    RC_ASSERT(found->id == id);
  }
}

RC_GTEST_PROP(LandmarkRegistry, FindsExactlyWhatIsNear, ()) {
  RegistryAndList both;
  const Vector2d centre = anyPlace();
  const double radius_m = anyInteger(0, 3000) * 0.01;
  std::vector<int> expected;
  for (const auto& [id, listed] : both.list) {
    const Vector2d difference = listed.position - centre;
    if (difference.squaredNorm() <= radius_m * radius_m) expected.push_back(listed.slot);
  }
  std::sort(expected.begin(), expected.end());
  RC_ASSERT(both.registry.slotsNear(centre, radius_m) == expected);
}

RC_GTEST_PROP(LandmarkRegistry, ForgetsIdentitiesOfWhatLeft, ()) {
  RegistryAndList both;
  for (int identity = 1000; identity < 1120; ++identity) {
    const bool listed =
        both.list.count(identity - 1000) > 0 && both.list.at(identity - 1000).identity == identity;
    RC_ASSERT((both.registry.findIdentity(identity) != nullptr) == listed);
  }
}

RC_GTEST_PROP(LandmarkIndex, NeverMissesASlotWithinTheCircle, ()) {
  LandmarkIndex index;
  std::map<int, Vector2d> places;
  const int steps = anyInteger(1, 80);
  for (int i = 0; i < steps; ++i) {
    const int slot = anyInteger(0, 20);
    if (anyInteger(0, 4) == 0) {
      index.remove(slot);
      places.erase(slot);
    } else {
      places[slot] = anyPlace();
      index.place(slot, places[slot]);
    }
  }
  const Vector2d centre = anyPlace();
  const double radius_m = anyInteger(0, 3000) * 0.01;
  const std::vector<int> near = index.near(centre, radius_m);
  RC_ASSERT(std::is_sorted(near.begin(), near.end()));
  for (const int slot : near) RC_ASSERT(places.count(slot) == 1U);
  for (const auto& [slot, place] : places) {
    if ((place - centre).norm() > radius_m) continue;
    RC_ASSERT(std::count(near.begin(), near.end(), slot) == 1);
  }
}

}  // namespace
}  // namespace hymm::core
