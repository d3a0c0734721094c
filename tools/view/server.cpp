// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/server.h"

#include <fmt/format.h>

#include <boost/asio/post.hpp>
#include <thread>

#include "tools/view/client.h"
#include "tools/view/http.h"
#include "tools/view/orders.h"

namespace stroma::view {
namespace {

namespace asio = boost::asio;
using nlohmann::json;
using Tcp = asio::ip::tcp;

std::shared_ptr<const std::string> textOf(const json& message) {
  return std::make_shared<std::string>(message.dump(-1, ' ', false, json::error_handler_t::replace));
}

/// Throws std::runtime_error.
Tcp::acceptor listenOn(asio::io_context& context, const std::string& host, int port) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(host == "localhost" ? "127.0.0.1" : host, error);
  if (error)
    throw std::runtime_error(fmt::format("--host {}: expected an address of this machine, as 127.0.0.1", host));
  Tcp::acceptor acceptor(context);
  const Tcp::endpoint endpoint(address, static_cast<unsigned short>(port));
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(Tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    throw std::runtime_error(fmt::format("port {} is taken: give another --port, or none to take a free one", port));
  if (error) throw std::runtime_error(fmt::format("cannot listen on {}:{}: {}", host, port, error.message()));
  return acceptor;
}

}  // namespace

Server::Server(const ViewRequest& request)
    : request_(request),
      acceptor_(listenOn(context_, request.host, request.port)),
      access_(request.host, acceptor_.local_endpoint().port(), request.framed_by),
      signals_(context_, SIGINT, SIGTERM) {}

Server::~Server() = default;

int Server::serve(LiveRun& run) {
  run_ = &run;
  signals_.async_wait([this](const boost::system::error_code& error, int signal) {
    if (error) return;
    signal_ = signal;
    context_.stop();
  });
  accept();
  std::thread stepping([&run] { run.loop(); });
  // whatever happens here, the run ends with its last whole step
  const std::shared_ptr<void> end(nullptr, [&run, &stepping](void*) { run.stop(), stepping.join(); });
  if (request_.opened) request_.opened(access_.address());
  context_.run();
  for (const auto clients = clients_; const auto& [number, client] : clients) client->close();
  return signal_;
}

void Server::accept() {
  acceptor_.async_accept([this](const boost::system::error_code& error, Tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && !isFull()) {
      boost::system::error_code ignored;
      socket.set_option(Tcp::no_delay(true), ignored);
      std::make_shared<HttpConnection>(*this, std::move(socket))->start();
    }
    if (!error) return accept();
    // out of descriptors, perhaps: not again at once
    pause_.expires_after(std::chrono::milliseconds(200));
    pause_.async_wait([this](const boost::system::error_code& stopped) {
      if (!stopped) accept();
    });
  });
}

// ---- from the thread that steps ----

void Server::send(int client, const json& message) {
  if (message.value("is", "") == "status") {
    asio::post(context_, [this, client, message] { deliver(client, textOf(withControl(message)), true); });
    return;
  }
  asio::post(context_, [this, client, bytes = textOf(message)] { deliver(client, bytes, true); });
}

void Server::sendPacket(int client, const Packet& packet) {
  asio::post(context_, [this, client, bytes = std::make_shared<const std::string>(packet.bytes())] {
    deliver(client, bytes, false);
  });
}

void Server::show(std::shared_ptr<const Packet> frame) {
  asio::post(context_, [this, frame = std::move(frame)] {
    for (const auto clients = clients_; const auto& [number, client] : clients) client->show(frame);
    demandChanged();
  });
}

void Server::tellStatus(const json& status) {
  asio::post(context_, [this, status] {
    const auto bytes = textOf(withControl(status));
    for (const auto clients = clients_; const auto& [number, client] : clients) client->tellStatus(bytes);
  });
}

/// Who has control is known here, not to the run.
json Server::withControl(json status) const {
  status["control"] = control_ == 0 ? json() : json(control_);
  status["clients"] = clients_.size();
  return status;
}

void Server::deliver(int client, std::shared_ptr<const std::string> bytes, bool is_text) {
  // the first packet for a page is its scene: from then on it can draw
  const auto one = clients_.find(client);
  if (!is_text && one != clients_.end() && !one->second->isReady()) {
    one->second->setReady();
    one->second->queue(std::move(bytes), is_text);
    demandChanged();
    return;
  }
  // a list of its own: a client that does not read is dropped while it is gone through
  for (const auto clients = clients_; const auto& [number, each] : clients)
    if (client == everybody ? each->isReady() : number == client) each->queue(bytes, is_text);
}

// ---- pages ----

int Server::join(const std::shared_ptr<Client>& client) {
  clients_[next_client_] = client;
  return next_client_++;
}

void Server::leave(int client) {
  clients_.erase(client);
  if (control_ == client) control_ = 0;
  if (run_) run_->post({client, {{"do", "leave"}}});
  demandChanged();
}

void Server::demandChanged() {
  Demand all;
  all.fps = 0;
  for (const auto& [number, client] : clients_) {
    if (!client->isReady()) continue;
    const Demand& one = client->demand();
    all.connected = true;
    all.can_draw = all.can_draw || client->wantsFrames();
    all.all_nodes = all.all_nodes || one.all_nodes, all.loads = all.loads || one.loads;
    all.contacts = all.contacts || one.contacts;
    all.fps = std::max(all.fps, one.fps);
    all.fields.insert(one.fields.begin(), one.fields.end());
    all.values.insert(one.values.begin(), one.values.end());
  }
  all.fps = all.fps > 0 ? std::min(all.fps, request_.fps) : request_.fps;
  run_->setDemand(all);
}

void Server::setControl(int client) {
  // the page that had control can no longer release it
  if (control_ != 0 && control_ != client) run_->post({control_, {{"do", "leave"}}});
  control_ = client;
  run_->post({client, {{"do", "show"}}});
}

void Server::refuse(Client& client, const json& message, const std::string& why) {
  if (message.contains("request"))
    client.queue(textOf({{"is", "reply"}, {"request", message["request"]}, {"ok", false}, {"message", why}}), true);
  else
    client.queue(textOf({{"is", "messages"}, {"lines", {{{"severity", "error"}, {"text", why}}}}}), true);
}

void Server::take(Client& client, json message) {
  const auto accepted = [&] {
    if (message.contains("request"))
      client.queue(textOf({{"is", "reply"}, {"request", message["request"]}, {"ok", true}, {"message", ""}}), true);
  };
  try {
    const std::string verb = checkedVerb(message);
    if (verb == "hello") {
      if (client.hasGreeted()) throw ComponentError("'hello' comes once");
      // a page that has just been loaded does not know yet which build it is of
      const std::string build = text(message.value("build", json("")), "build", 200);
      if (!build.empty() && build != request_.build) {
        client.queue(textOf({{"is", "reload"}}), true);
        return;
      }
      client.greet();
      if (control_ == 0) control_ = client.number();
      run_->post({client.number(), {{"do", "attach"}}});
      return accepted();
    }
    if (!client.hasGreeted()) throw ComponentError("the first message is not 'hello'");
    if (verb == "drawn") {
      client.drawn(integer(member(message, "frame"), "frame", 0, 1L << 52));
      demandChanged();
      accepted();
    } else if (verb == "want") {
      client.setWants(message, *run_);
      demandChanged();
      run_->post({client.number(), {{"do", "show"}}});
      accepted();
    } else if (verb == "watch") {
      std::set<std::string> values;
      const json list = message.value("values", json::array());
      if (!list.is_array() || list.size() > 64) throw ComponentError("'values' is not a list of at most 64 words");
      for (const json& word : list) values.insert(text(word, "values", 80));
      run_->checkWanted({}, values);
      client.setValues(std::move(values));
      demandChanged();
      run_->post({client.number(), {{"do", "show"}}});
      accepted();
    } else if (verb == "control") {
      setControl(client.number());
      accepted();
    } else if (needsControl(verb) && control_ != 0 && control_ != client.number()) {
      throw ComponentError("another page has control", "control taken first");
    } else {
      if (needsControl(verb) && control_ == 0) control_ = client.number();
      if (!run_->post({client.number(), message})) refuse(client, message, "too many messages wait already");
    }
  } catch (const json::exception& error) {
    refuse(client, message, error.what());
  } catch (const ComponentError& error) {
    refuse(client, message, sentenceOf(error));
  }
}

}  // namespace stroma::view
