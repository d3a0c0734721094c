// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>
#include <string>

#include "tools/view/audience.h"

namespace stroma::view {

class LiveRun;
class Server;

/// The websocket of one page. What has to arrive waits in a queue; of frames and of states of the run only the newest waits,
/// and no more than two frames are under way that the page has not drawn: a page that is slow or hidden sees fewer, nothing
/// piles up, and nobody waits for it.
class Client : public std::enable_shared_from_this<Client> {
 public:
  using Tcp = boost::asio::ip::tcp;
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  Client(Server& server, Tcp::socket socket);

  void accept(Request request);
  void queue(std::shared_ptr<const std::string> bytes, bool is_text);
  void show(std::shared_ptr<const Packet> frame);
  void tellStatus(std::shared_ptr<const std::string> status);
  void close();

  int number() const { return number_; }
  /// It has said what it is, and may ask.
  bool hasGreeted() const { return has_greeted_; }
  void greet() { has_greeted_ = true; }
  /// It has been sent the scene, and can be sent frames of it.
  bool isReady() const { return is_ready_; }
  void setReady() { is_ready_ = true; }
  bool wantsFrames() const { return is_ready_ && !next_frame_ && under_way_ < most_under_way; }
  const Demand& demand() const { return demand_; }
  /// Reads "want" of the page. Throws ComponentError.
  void setWants(const nlohmann::json& message, const LiveRun& run);
  void setValues(std::set<std::string> values) { demand_.values = std::move(values); }
  void drawn(long frame);

 private:
  static constexpr int most_under_way = 2;
  struct Outgoing {
    std::shared_ptr<const std::string> bytes;
    bool is_text = true;
  };
  void read();
  void taken(std::size_t bytes);
  void write();
  bool nextOutgoing();
  void gone();

  Server& server_;
  boost::beast::websocket::stream<boost::beast::tcp_stream, false> stream_;  // that does not compress
  boost::beast::flat_buffer buffer_;
  int number_ = 0;
  bool has_greeted_ = false, is_ready_ = false, writing_ = false, gone_ = false, short_positions_ = false;
  std::deque<Outgoing> queue_;
  std::size_t queued_bytes_ = 0;
  std::shared_ptr<const Packet> next_frame_;
  std::shared_ptr<const std::string> next_status_;
  Outgoing current_;
  int under_way_ = 0;
  long last_sent_ = 0;
  Demand demand_;
};

}  // namespace stroma::view
