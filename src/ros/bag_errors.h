#pragma once

#include <exception>
#include <filesystem>
#include <map>
#include <string>

#include <rosbag/bag.h>
#include <rosbag/exceptions.h>
#include <rosbag/view.h>

#include "common/error.h"
#include "ros/bag_structure.h"

namespace hymm {

/// Runs `work` on the bag at `path`. Whatever goes wrong with the file becomes a core::InputError
/// that names it and says what to do.
template <class Work>
auto withBagErrors(const std::string& path, const Work& work) {
  std::error_code problem;
  if (!std::filesystem::is_regular_file(path, problem)) {
    throw core::InputError(path + ": there is no such file.");
  }
  if (std::filesystem::file_size(path, problem) == 0) {
    throw core::InputError(path + ": the file is empty (0 bytes), not a bag.");
  }
  const std::string reindex = " Try `rosbag reindex " + path + "`, then run again.";
  try {
    return work();
  } catch (const core::InputError&) {
    throw;
  } catch (const rosbag::BagUnindexedException&) {
    throw core::InputError(path + ": the bag was not closed, so it has no index." + reindex);
  } catch (const NotABag& error) {
    throw core::InputError(path + ": is no bag (" + error.what() +
                           "). Older bags become new ones by `rosbag fix`.");
  } catch (const BagCutOff& error) {
    throw core::InputError(path + ": the bag is cut off (" + error.what() + ")." + reindex);
  } catch (const rosbag::BagIOException& error) {
    throw core::InputError(path + ": the bag is cut off or cannot be read (" + error.what() + ")." +
                           reindex);
  } catch (const std::exception& error) {
    throw core::InputError(path + ": the bag is damaged (" + error.what() + ")." + reindex);
  }
}

/// Opens a bag to be read, within withBagErrors(), once it is known that its records fit.
inline void openBag(rosbag::Bag& bag, const std::string& path) {
  checkBagStructure(path);
  bag.open(path, rosbag::bagmode::Read);
}

/// The topics of a bag and their types, for a sentence.
inline std::string topicsOf(const std::string& path) {
  return withBagErrors(path, [&] {
    rosbag::Bag bag;
    openBag(bag, path);
    std::map<std::string, std::string> types;
    for (const rosbag::ConnectionInfo* info : rosbag::View(bag).getConnections()) {
      types[info->topic] = info->datatype;
    }
    std::string list;
    for (const auto& [topic, type] : types) {
      list += (list.empty() ? "" : ", ") + topic + " (" + type + ")";
    }
    return list;
  });
}

/// Throws core::InputError unless the bag can be opened and holds messages.
inline void checkBag(const std::string& path) {
  withBagErrors(path, [&] {
    rosbag::Bag bag;
    openBag(bag, path);
    if (rosbag::View(bag).size() > 0) return;
    throw core::InputError(path + ": the bag is empty, it holds no messages.");
  });
}

}  // namespace hymm
