#include "ros/node_graph.h"

#include <cstdint>
#include <optional>
#include <utility>

#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpc.h>

namespace hymm {
namespace {

NodesByTopic nodesByTopic(XmlRpc::XmlRpcValue& topics) {
  NodesByTopic nodes;
  for (int topic = 0; topic < topics.size(); ++topic) {
    std::set<std::string>& of_topic = nodes[static_cast<std::string>(topics[topic][0])];
    for (int i = 0; i < topics[topic][1].size(); ++i) {
      of_topic.insert(static_cast<std::string>(topics[topic][1][i]));
    }
  }
  return nodes;
}

std::string addressOf(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, address;
  request[0] = ros::this_node::getName();
  request[1] = node;
  const bool is_told = ros::master::execute("lookupNode", request, response, address, false);
  return is_told ? static_cast<std::string>(address) : std::string();
}

using Link = std::pair<std::string, std::string>;  // topic, address of the publisher

/// What comes into the node at this address, by the slave API's getBusInfo; nothing if it does not
/// answer.
std::optional<std::set<Link>> linksInto(const std::string& address) {
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(address, host, port)) return std::nullopt;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue request, response;
  request[0] = ros::this_node::getName();
  const bool answered = client.execute("getBusInfo", request, response) && !client.isFault();
  client.close();
  if (!answered || response.getType() != XmlRpc::XmlRpcValue::TypeArray || response.size() < 3) {
    return std::nullopt;
  }
  std::set<Link> links;
  XmlRpc::XmlRpcValue& connections = response[2];
  for (int i = 0; i < connections.size(); ++i) {
    // (id, publisher, "i", transport, topic, ...)
    XmlRpc::XmlRpcValue& connection = connections[i];
    if (static_cast<std::string>(connection[2]) != "i") continue;
    links.emplace(static_cast<std::string>(connection[4]), static_cast<std::string>(connection[1]));
  }
  return links;
}

}  // namespace

std::set<std::string> NodeGraph::subscribedNodes() const {
  std::set<std::string> nodes;
  for (const auto& [topic, of_topic] : subscribers) nodes.insert(of_topic.begin(), of_topic.end());
  return nodes;
}

NodeGraph presentGraph() {
  XmlRpc::XmlRpcValue request, response, state;
  request[0] = ros::this_node::getName();
  if (!ros::master::execute("getSystemState", request, response, state, false)) return {};
  return {nodesByTopic(state[0]), nodesByTopic(state[1])};
}

std::set<std::string> missingLinks(const NodeGraph& graph, const std::string& node) {
  const std::optional<std::set<Link>> links = linksInto(addressOf(node));
  if (!links) return {node};
  std::set<std::string> missing;
  for (const auto& [topic, subscribers] : graph.subscribers) {
    const auto published = graph.publishers.find(topic);
    if (subscribers.count(node) == 0 || published == graph.publishers.end()) continue;
    for (const std::string& publisher : published->second) {
      if (links->count({topic, addressOf(publisher)}) > 0) continue;
      missing.insert(topic + " from " + publisher);
    }
  }
  return missing;
}

}  // namespace hymm
