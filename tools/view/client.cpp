// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/client.h"

#include "tools/view/orders.h"
#include "tools/view/server.h"

namespace stroma::view {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using nlohmann::json;

constexpr std::size_t most_message_bytes = 64 << 10;
constexpr std::size_t most_queued_bytes = 256u << 20;  // the cells of ten million tetrahedra
constexpr std::size_t most_queued = 2000;
constexpr int deepest = 16;  ///< nested brackets in a message

/// Null for what is no JSON object, or nested too deep.
json parse(std::string_view text) {
  bool too_deep = false;
  const auto watch = [&too_deep](int depth, json::parse_event_t, json&) {
    too_deep = too_deep || depth > deepest;
    return !too_deep;
  };
  json message = json::parse(text, watch, false);
  return message.is_object() && !too_deep ? message : json();
}

}  // namespace

Client::Client(Server& server, Tcp::socket socket) : server_(server), stream_(std::move(socket)) {}

void Client::accept(Request request) {
  stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  stream_.auto_fragment(false);
  stream_.read_message_max(most_message_bytes);
  beast::get_lowest_layer(stream_).expires_never();
  stream_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
    if (error) return;
    self->number_ = self->server_.join(self);
    self->read();
  });
}

void Client::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, std::size_t bytes) {
    if (error) {
      self->gone();
      return;
    }
    self->taken(bytes);
    if (!self->gone_) self->read();
  });
}

void Client::taken(std::size_t bytes) {
  if (!stream_.got_text()) {
    close();  // a page sends no binary messages
    return;
  }
  json message = parse({static_cast<const char*>(buffer_.data().data()), bytes});
  buffer_.consume(buffer_.size());
  if (message.is_null()) {
    queue(std::make_shared<std::string>(
              R"({"is":"messages","lines":[{"severity":"error","text":"a message was no JSON object"}]})"),
          true);
    return;
  }
  server_.take(*this, std::move(message));
}

void Client::gone() {
  if (gone_) return;
  gone_ = true;
  if (number_ != 0) server_.leave(number_);
}

void Client::close() {
  if (gone_) return;
  beast::get_lowest_layer(stream_).cancel();
  beast::error_code ignored;
  beast::get_lowest_layer(stream_).socket().shutdown(Tcp::socket::shutdown_both, ignored);
  gone();
}

void Client::queue(std::shared_ptr<const std::string> bytes, bool is_text) {
  if (gone_) return;
  queued_bytes_ += bytes->size();
  queue_.push_back({std::move(bytes), is_text});
  if (queued_bytes_ > most_queued_bytes || queue_.size() > most_queued) {
    close();  // it does not read
    return;
  }
  write();
}

void Client::show(std::shared_ptr<const Packet> frame) {
  if (!is_ready_ || gone_) return;
  next_frame_ = std::move(frame);
  write();
}

void Client::tellStatus(std::shared_ptr<const std::string> status) {
  if (!is_ready_ || gone_) return;
  next_status_ = std::move(status);
  write();
}

void Client::drawn(long frame) {
  if (frame > last_sent_ || under_way_ == 0) return;
  under_way_ = frame == last_sent_ ? 0 : std::max(0, under_way_ - 1);
  write();
}

bool Client::nextOutgoing() {
  if (!queue_.empty()) {
    current_ = std::move(queue_.front());
    queue_.pop_front();
    queued_bytes_ -= current_.bytes->size();
  } else if (next_status_) {
    current_ = {std::move(next_status_), true};
    next_status_ = nullptr;
  } else if (next_frame_ && under_way_ < most_under_way) {
    last_sent_ = next_frame_->header()["frame"].get<long>();
    current_ = {std::make_shared<std::string>(short_positions_ ? withShortPositions(*next_frame_).bytes()
                                                               : next_frame_->bytes()),
                false};
    next_frame_ = nullptr;
    ++under_way_;
  } else {
    return false;
  }
  return true;
}

void Client::write() {
  if (writing_ || gone_ || !nextOutgoing()) return;
  writing_ = true;
  stream_.text(current_.is_text);
  stream_.async_write(boost::asio::buffer(*current_.bytes),
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        self->writing_ = false;
                        self->current_ = {};
                        if (error) {
                          self->gone();
                          return;
                        }
                        self->server_.demandChanged();
                        self->write();
                      });
}

void Client::setWants(const json& message, const LiveRun& run) {
  Demand wanted = demand_;
  const std::string nodes = text(message.value("nodes", json("surface")), "nodes", 20);
  if (nodes != "surface" && nodes != "all") throw ComponentError("'nodes' is '" + nodes + "'", "surface or all");
  const std::string format = text(message.value("format", json("f32")), "format", 20);
  if (format != "f32" && format != "u16") throw ComponentError("'format' is '" + format + "'", "f32 or u16");
  const json fields = message.value("fields", json::array());
  if (!fields.is_array() || fields.size() > 64) throw ComponentError("'fields' is not a list of at most 64 numbers");
  wanted.fields.clear();
  for (const json& field : fields) wanted.fields.insert(int(integer(field, "fields", 1, 1 << 20)));
  const json loads = message.value("loads", json(false));
  if (!loads.is_boolean()) throw ComponentError("'loads' is neither true nor false");
  const json contacts = message.value("contacts", json(false));
  if (!contacts.is_boolean()) throw ComponentError("'contacts' is neither true nor false");
  wanted.fps = view::number(message.value("fps", json(60)), "fps", 0.1, 240);
  wanted.all_nodes = nodes == "all", wanted.loads = loads.get<bool>(), wanted.contacts = contacts.get<bool>();
  run.checkWanted(wanted.fields, {});
  short_positions_ = format == "u16";
  demand_ = std::move(wanted);
}

}  // namespace stroma::view
