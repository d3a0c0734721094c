// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <map>
#include <memory>

#include "tools/view/access.h"
#include "tools/view/audience.h"
#include "tools/view/live_run.h"
#include "tools/view/viewer.h"

namespace stroma::view {

class Client;

/// Serves the page and its websockets in the thread that calls serve(), and passes on what pages and run have to say.
class Server final : public Audience {
 public:
  /// Listens. Throws std::runtime_error with a sentence when the address is taken or no address of this machine.
  explicit Server(const ViewRequest& request);
  ~Server() override;

  const Access& access() const { return access_; }
  /// Until SIGINT or SIGTERM, whose number is returned. `run` receives the requests of pages.
  int serve(LiveRun& run);

  // ---- Audience: the thread that steps ----
  void send(int client, const nlohmann::json& message) override;
  void sendPacket(int client, const Packet& packet) override;
  void show(std::shared_ptr<const Packet> frame) override;
  void tellStatus(const nlohmann::json& status) override;

  // ---- connections: the serving thread ----
  boost::asio::io_context& context() { return context_; }
  const std::string& build() const { return request_.build; }
  int join(const std::shared_ptr<Client>& client);  ///< returns its number
  void leave(int client);
  /// A message of a page.
  void take(Client& client, nlohmann::json message);
  void demandChanged();
  /// Of connections that may become pages, and of pages.
  bool isFull() const { return connections_ + int(clients_.size()) >= most_connections; }
  void countConnection(int change) { connections_ += change; }

 private:
  static constexpr int most_connections = 64;
  void accept();
  nlohmann::json withControl(nlohmann::json status) const;
  void deliver(int client, std::shared_ptr<const std::string> bytes, bool is_text);
  void setControl(int client);
  void refuse(Client& client, const nlohmann::json& message, const std::string& why);

  const ViewRequest& request_;
  boost::asio::io_context context_{1};
  boost::asio::ip::tcp::acceptor acceptor_;
  Access access_;
  boost::asio::signal_set signals_;
  boost::asio::steady_timer pause_{context_};  ///< after a connection that could not be accepted
  LiveRun* run_ = nullptr;
  std::map<int, std::shared_ptr<Client>> clients_;
  int next_client_ = 1, control_ = 0, connections_ = 0, signal_ = 0;
};

}  // namespace stroma::view
