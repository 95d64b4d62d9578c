#include "hybrid_map/layer_set.h"

#include <algorithm>
#include <sstream>

namespace hymm::core {
namespace {

/// A model by its name in the configuration; null, with a sentence, if there is none.
std::unique_ptr<CellModel> makeModel(const std::string& model,
                                     const std::vector<std::string>& words, int day_parts,
                                     std::string& problem) {
  if (model == "gaussian" && words.empty()) return makeGaussianModel();
  if (model == "category" && words.size() >= 2) return makeCategoryModel(words);
  if (model == "rate") return makeRateModel(day_parts, words);
  if (model == "gaussian") {
    problem = "a gaussian layer has no further words";
  } else if (model == "category") {
    problem = "a category layer needs the names of two categories or more";
  } else {
    problem = "there is no cell model '" + model + "'; there are gaussian, category and rate";
  }
  return nullptr;
}

std::vector<std::string> wordsOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

LayerSet::LayerSet(const std::string& description, int day_parts,
                   std::vector<std::string>& problems, const LogOddsLimits& occupancy_limits) {
  add("occupancy", "occupancy", makeOccupancyModel(occupancy_limits));
  std::istringstream entries(description);
  for (std::string entry; std::getline(entries, entry, ';');) {
    std::vector<std::string> words = wordsOf(entry);
    if (words.empty()) continue;
    const std::string name = words[0];
    std::string problem;
    if (words.size() < 2) {
      problem = "no cell model follows the name";
    } else if (find(name) >= 0) {
      problem = "there is another layer of this name";
    } else {
      const std::vector<std::string> rest(words.begin() + 2, words.end());
      if (auto model = makeModel(words[1], rest, day_parts, problem)) {
        std::string text = words[1];
        for (const std::string& word : rest) text += ' ' + word;
        add(name, text, std::move(model));
      }
    }
    if (problem.empty()) continue;
    std::ostringstream sentence;
    sentence << "layers: '" << name << "': " << problem << ".";
    problems.push_back(sentence.str());
  }
}

void LayerSet::add(const std::string& name, const std::string& model_text,
                   std::unique_ptr<CellModel> model) {
  const int channels = model->channels();
  layers_.push_back({name, model_text, std::move(model), channels});
}

int LayerSet::channelsTogether() const {
  int sum = 0;
  for (const Layer& layer : layers_) sum += layer.channels;
  return sum;
}

int LayerSet::find(const std::string& name) const {
  for (int i = 0; i < count(); ++i) {
    if (layers_[std::size_t(i)].name == name) return i;
  }
  return -1;
}

std::vector<std::string> LayerSet::names() const {
  std::vector<std::string> names;
  names.reserve(layers_.size());
  for (const Layer& layer : layers_) names.push_back(layer.name);
  return names;
}

}  // namespace hymm::core
