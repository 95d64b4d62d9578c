#pragma once

#include <map>
#include <set>
#include <string>

namespace hymm {

using NodesByTopic = std::map<std::string, std::set<std::string>>;

/// Who publishes and who subscribes, as the master knows it.
struct NodeGraph {
  NodesByTopic publishers, subscribers;

  /// All nodes that subscribe to anything.
  std::set<std::string> subscribedNodes() const;
};

/// Nothing if the master does not answer.
NodeGraph presentGraph();

/// Topics that `node` subscribes to and has no connection yet from a node that publishes them, as
/// "/topic from /publisher"; with `node` itself if it cannot be asked. Waits for its answer.
std::set<std::string> missingLinks(const NodeGraph& graph, const std::string& node);

}  // namespace hymm
