#include "door_planner/planner_feed.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

namespace hymm::core {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

float probabilityOf(const float* cell) {
  return cell[0] == 0.0F ? kUnknown : 1.0F / (1.0F + std::exp(-cell[0]));
}

float meanOf(const float* cell) { return cell[0] > 0.0F ? cell[1] : kUnknown; }

float eventsPerHour(const float* cell, std::size_t channels) {
  float events = 0.0F, hours = 0.0F;
  for (std::size_t i = 0; i + 1 < channels; i += 2) {
    events += cell[i];
    hours += cell[i + 1];
  }
  return hours > 0.0F ? events / hours : kUnknown;
}

template <class Reader>
std::vector<float> read(const std::vector<float>& cells, std::size_t channels, Reader&& reader) {
  std::vector<float> values;
  values.reserve(cells.size() / channels);
  for (std::size_t i = 0; i < cells.size(); i += channels) values.push_back(reader(&cells[i]));
  return values;
}

void readCategories(const std::string& name, std::istringstream& words, std::size_t channels,
                    const std::vector<float>& cells, LtrContent& content) {
  std::string category;
  for (std::size_t k = 0; k < channels && words >> category; ++k) {
    content.properties[name + "." + category] = read(cells, channels, [&](const float* cell) {
      float sum = 0.0F;
      for (std::size_t i = 0; i < channels; ++i) sum += cell[i];
      return sum > 0.0F ? cell[k] / sum : kUnknown;
    });
  }
}

}  // namespace

bool decodeLayer(const std::string& name, const std::string& model, int channel_count,
                 const std::vector<float>& cells, LtrContent& content) {
  const std::size_t channels = channel_count > 0 ? std::size_t(channel_count) : 0;
  if (channels == 0 || cells.size() % channels != 0) return false;
  std::istringstream words(model);
  std::string kind;
  words >> kind;
  if (kind == "occupancy" && channels == 1) {
    content.occupancy = read(cells, channels, probabilityOf);
  } else if (kind == "gaussian" && channels == 4) {
    content.properties[name] = read(cells, channels, meanOf);
  } else if (kind == "rate" && channels % 2 == 0) {
    content.properties[name] =
        read(cells, channels, [&](const float* cell) { return eventsPerHour(cell, channels); });
  } else if (kind == "category") {
    readCategories(name, words, channels, cells, content);
  } else {
    return false;
  }
  return true;
}

void PlannerFeed::setTopology(const std::vector<LtrTopology>& topology) {
  std::map<int, LtrTopology> before = std::move(topology_);
  topology_.clear();
  for (const LtrTopology& ltr : topology) {
    topology_[ltr.id] = ltr;
    before.erase(ltr.id);
  }
  // Layers of LTRs that are still to be told may have come first; those of retired ones go.
  for (const auto& [id, retired] : before) contents_.erase(id);
  geometry_changed_ = true;
}

void PlannerFeed::setLandmarks(const std::vector<LandmarkEstimate>& landmarks) {
  landmarks_.clear();
  solids_.clear();
  for (const LandmarkEstimate& landmark : landmarks) {
    landmarks_[landmark.id] = landmark.position;
    solids_.push_back({landmark.id, landmark.position, landmark.diameter_m});
  }
  geometry_changed_ = true;
}

bool PlannerFeed::setLayer(int ltr, const std::string& name, const std::string& model, int channels,
                           const std::vector<float>& cells) {
  const auto known = contents_.find(ltr);
  LtrContent content = known == contents_.end() ? LtrContent() : *known->second;
  if (!decodeLayer(name, model, channels, cells, content)) return false;
  contents_[ltr] = std::make_shared<const LtrContent>(std::move(content));
  changed_.insert(ltr);
  return true;
}

void PlannerFeed::reset() { *this = PlannerFeed(); }

bool PlannerFeed::tell(DoorPlanner& planner) {
  if (!geometry_changed_ && changed_.empty()) return false;
  if (geometry_changed_) {
    std::vector<LtrView> views;
    std::set<int> present;
    for (const auto& [id, ltr] : topology_) {
      LtrView view{id,
                   ltr.landmark_ids,
                   ltr.neighbours,
                   {},
                   ltr.alpha_cells,
                   ltr.beta_cells,
                   ltr.shape_factor};
      bool is_whole = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<Eigen::Vector2d> place = findLandmark(ltr.landmark_ids[k]);
        if (place) view.corners[k] = *place;
        is_whole = is_whole && place;
      }
      if (!is_whole) continue;
      views.push_back(view);
      present.insert(id);
      if (told_.count(id) == 0) changed_.insert(id);
    }
    waiting_ = topology_.size() - views.size();
    unusable_ = planner.setLtrs(views);
    for (const auto& [id, problem] : unusable_) present.erase(id);
    planner.setLandmarks(solids_);
    told_ = std::move(present);
    geometry_changed_ = false;
  }
  for (const int id : changed_) {
    if (told_.count(id) == 0) continue;
    std::shared_ptr<const LtrContent>& content = contents_[id];
    if (!content) content = std::make_shared<const LtrContent>();
    if (!planner.setContent(id, content)) ++refused_;
  }
  changed_.clear();
  return true;
}

std::optional<Eigen::Vector2d> PlannerFeed::findLandmark(int id) const {
  const auto found = landmarks_.find(id);
  if (found == landmarks_.end()) return std::nullopt;
  return found->second;
}

}  // namespace hymm::core
