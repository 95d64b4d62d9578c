#include "ros/player_arguments.h"

#include <cstdlib>
#include <sstream>
#include <string_view>

#include "ros/bag_errors.h"

namespace hymm {
namespace {

/// How many values an option of `rosbag play` takes.
enum class Values { kNone, kOne, kMany };

struct Option {
  const char* name;
  char letter;  ///< 0 if it has none
  Values values;
};

constexpr Option kOptions[] = {{"help", 'h', Values::kNone},
                               {"prefix", 'p', Values::kOne},
                               {"quiet", 'q', Values::kNone},
                               {"immediate", 'i', Values::kNone},
                               {"pause", 0, Values::kNone},
                               {"queue", 0, Values::kOne},
                               {"clock", 0, Values::kNone},
                               {"hz", 0, Values::kOne},
                               {"delay", 'd', Values::kOne},
                               {"rate", 'r', Values::kOne},
                               {"start", 's', Values::kOne},
                               {"duration", 'u', Values::kOne},
                               {"skip-empty", 0, Values::kOne},
                               {"loop", 'l', Values::kNone},
                               {"keep-alive", 'k', Values::kNone},
                               {"try-future-version", 0, Values::kNone},
                               {"topics", 0, Values::kMany},
                               {"pause-topics", 0, Values::kMany},
                               {"bags", 0, Values::kMany},
                               {"wait-for-subscribers", 0, Values::kNone},
                               {"rate-control-topic", 0, Values::kOne},
                               {"rate-control-max-delay", 0, Values::kOne}};

const Option* findOption(const std::string& name) {
  for (const Option& option : kOptions) {
    const bool is_it = name.size() == 1 ? option.letter == name[0] : option.name == name;
    if (is_it) return &option;
  }
  return nullptr;
}

bool isOption(const std::string& word) { return word.size() > 1 && word[0] == '-'; }

/// Walks over the words of a command line.
class Reader {
 public:
  explicit Reader(const std::string& arguments) {
    std::istringstream stream(arguments);
    for (std::string word; stream >> word;) words_.push_back(word);
  }

  /// False if a word cannot be understood.
  bool readAll(PlayerArguments& arguments) {
    while (next_ < words_.size()) {
      if (!readOption(arguments)) return false;
    }
    return true;
  }

 private:
  bool readOption(PlayerArguments& arguments) {
    std::string name = words_[next_++];
    if (!isOption(name)) return true;  // another bag, or nothing that rosbag would take
    std::optional<std::string> value;
    if (name[1] == '-') {
      const std::size_t sign = name.find('=');
      if (sign != std::string::npos) value = name.substr(sign + 1);
      name = name.substr(2, sign == std::string::npos ? sign : sign - 2);
      if (name.size() == 1) return false;
    } else {
      if (name.size() > 2) value = name.substr(2);
      name = name.substr(1, 1);
    }
    const Option* option = findOption(name);
    if (option == nullptr) return false;
    if (option->values == Values::kNone) return !value && readFlag(*option, arguments);
    if (option->values == Values::kMany) return readMany(*option, value, arguments);
    if (!value && next_ < words_.size()) value = words_[next_++];
    return value && readValue(*option, *value, arguments);
  }

  static bool readFlag(const Option& option, PlayerArguments& arguments) {
    if (option.letter == 'l') arguments.loops = true;
    return true;
  }

  bool readMany(const Option& option, const std::optional<std::string>& first,
                PlayerArguments& arguments) {
    std::vector<std::string> values;
    if (first) values.push_back(*first);
    while (next_ < words_.size() && !isOption(words_[next_])) values.push_back(words_[next_++]);
    if (std::string_view(option.name) == "topics") arguments.topics = values;
    return true;
  }

  static bool readValue(const Option& option, const std::string& text, PlayerArguments& arguments) {
    if (option.letter != 's' && option.letter != 'u') return true;
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0') return false;
    if (option.letter == 's') arguments.start_s = value;
    if (option.letter == 'u') arguments.duration_s = value;
    return true;
  }

  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

}  // namespace

std::optional<PlayerArguments> parsePlayerArguments(const std::string& arguments) {
  PlayerArguments parsed;
  if (!Reader(arguments).readAll(parsed)) return std::nullopt;
  return parsed;
}

PlayedSpan playedSpan(const std::string& path, const PlayerArguments& arguments) {
  checkBag(path);
  return withBagErrors(path, [&] {
    rosbag::Bag bag;
    openBag(bag, path);
    const ros::Time begin = rosbag::View(bag).getBeginTime() + ros::Duration(arguments.start_s);
    const ros::Time end =
        arguments.duration_s ? begin + ros::Duration(*arguments.duration_s) : ros::TIME_MAX;
    rosbag::View view;
    if (arguments.topics.empty()) {
      view.addQuery(bag, begin, end);
    } else {
      view.addQuery(bag, rosbag::TopicQuery(arguments.topics), begin, end);
    }
    if (view.size() == 0) {
      throw core::InputError(path + ": no message lies in the part that play_args choose.");
    }
    return PlayedSpan{view.getBeginTime().toSec(), view.getEndTime().toSec()};
  });
}

}  // namespace hymm
