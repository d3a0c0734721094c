// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "tools/view/packet.h"

namespace stroma::view {

/// Who looks at a run. Every function is called by the thread that steps, and returns at once.
class Audience {
 public:
  static constexpr int everybody = 0;  ///< in place of a client's number

  virtual ~Audience() = default;
  /// Arrives, in order.
  virtual void send(int client, const nlohmann::json& message) = 0;
  virtual void sendPacket(int client, const Packet& packet) = 0;
  /// The newest takes the place of one that has not been sent yet.
  virtual void show(std::shared_ptr<const Packet> frame) = 0;
  virtual void tellStatus(const nlohmann::json& status) = 0;
};

/// What all clients together want of frames.
struct Demand {
  bool connected = false;  ///< somebody is
  bool can_draw = false;   ///< somebody has drawn what was sent before
  bool all_nodes = false;  ///< those inside too
  bool loads = false;      ///< forces of the scene's loads
  bool contacts = false;   ///< forces of contact
  double fps = 60;
  std::set<int> fields{};          ///< numbers of Drawing::fields
  std::set<std::string> values{};  ///< words of "watch"
};

}  // namespace stroma::view
