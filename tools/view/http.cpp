// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/http.h"

#include <boost/beast/websocket.hpp>

#include "tools/view/client.h"
#include "tools/view/page_files.h"
#include "tools/view/server.h"

namespace stroma::view {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
constexpr auto longest_wait = std::chrono::seconds(20);

std::string_view viewOf(beast::string_view text) { return {text.data(), text.size()}; }

/// What a page may load, and who may show it in a frame.
std::string policy(const std::string& framed_by) {
  return "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
         "media-src blob:; frame-ancestors " +
         framed_by + "; base-uri 'none'; form-action 'none'";
}

HttpConnection::Response respond(const HttpConnection::Request& request, http::status status, std::string body,
                                 std::string_view type = "text/plain; charset=utf-8") {
  HttpConnection::Response response(status, request.version());
  response.set(http::field::content_type, beast::string_view(type.data(), type.size()));
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("X-Frame-Options", "DENY");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Content-Security-Policy", policy("'none'"));
  response.keep_alive(request.keep_alive());
  response.body() = std::move(body);
  response.prepare_payload();
  return response;
}

/// An answer for who has the token: the pages named may show it.
HttpConnection::Response framed(HttpConnection::Response response, const Access& access) {
  if (!access.isFramed()) return response;
  response.erase("X-Frame-Options");  // knows no names
  response.set("Content-Security-Policy", policy(access.framedBy()));
  return response;
}

/// The address of this machine at the end of a connection, as a browser writes it; empty when it has gone.
std::string localAddress(const boost::asio::ip::tcp::socket& socket) {
  namespace ip = boost::asio::ip;
  beast::error_code error;
  ip::address address = socket.local_endpoint(error).address();
  if (error) return {};
  if (!address.is_v6()) return address.to_string();
  ip::address_v6 six = address.to_v6();
  if (six.is_v4_mapped()) return ip::make_address_v4(ip::v4_mapped, six).to_string();
  six.scope_id(0);  // no name of a host has it
  return six.to_string();
}

}  // namespace

HttpConnection::HttpConnection(Server& server, boost::asio::ip::tcp::socket socket)
    : server_(server), local_(localAddress(socket)), stream_(std::move(socket)) {
  server_.countConnection(1);
}

HttpConnection::~HttpConnection() {
  if (is_counted_) server_.countConnection(-1);
}

boost::asio::ip::tcp::socket HttpConnection::release() {
  is_counted_ = false;
  server_.countConnection(-1);
  return stream_.release_socket();
}

/// One name, and it is ours: of two somebody else may read the other.
bool HttpConnection::namesUs(const Request& request) const {
  return request.count(http::field::host) == 1 &&
         server_.access().isOurHost(viewOf(request[http::field::host]), local_);
}

void HttpConnection::read() {
  parser_.emplace();
  parser_->header_limit(8 << 10);
  parser_->body_limit(0);
  stream_.expires_after(longest_wait);
  http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error == boost::asio::error::operation_aborted)
      return;
    if (error) {  // an answer where there can be one
      Request none;
      none.version(11), none.keep_alive(false);
      self->write(respond(none, http::status::bad_request, "This is no request that can be answered here.\n"));
      return;
    }
    self->taken();
  });
}

void HttpConnection::taken() {
  Request request = parser_->release();
  const Access& access = server_.access();
  const bool is_ours = namesUs(request);
  if (is_ours && beast::websocket::is_upgrade(request) && request.target() == "/live") {
    if (access.isOurOrigin(viewOf(request[http::field::origin]), local_) &&
        access.hasCookie(viewOf(request[http::field::cookie]))) {
      std::make_shared<Client>(server_, release())->accept(std::move(request));
      return;
    }
    request.keep_alive(false);
    write(respond(request, http::status::forbidden, "This page may not see the run.\n"));
    return;
  }
  write(answer(request));
}

HttpConnection::Response HttpConnection::answer(const Request& request) const {
  const Access& access = server_.access();
  if (!namesUs(request)) return respond(request, http::status::forbidden, "This server is not called so.\n");
  const std::string_view origin = viewOf(request[http::field::origin]);
  if (!origin.empty() && !access.isOurOrigin(origin, local_))
    return respond(request, http::status::forbidden, "Pages of other origins see nothing here.\n");
  if (request.method() != http::verb::get)
    return respond(request, http::status::method_not_allowed, "Only GET is answered.\n");
  return page(request);
}

HttpConnection::Response HttpConnection::page(const Request& request) const {
  const Access& access = server_.access();
  const std::string_view target = viewOf(request.target());
  constexpr std::string_view with_token = "/?token=";
  if (target.starts_with(with_token) && access.isToken(target.substr(with_token.size()))) {
    // the token is not left in the address bar, nor in the history
    Response response = respond(request, http::status::see_other, "");
    response.set(http::field::location, "/");
    response.set(http::field::set_cookie, access.cookie());
    return framed(std::move(response), access);
  }
  if (!access.hasCookie(viewOf(request[http::field::cookie])))
    return respond(request, http::status::forbidden,
                   "Open the address printed by `stroma view`: it contains a token that this request lacks.\n");
  const PageFile* file = pageFile(target);
  if (!file) return respond(request, http::status::not_found, "There is no such page.\n");
  return framed(respond(request, http::status::ok, std::string(file->content), file->type), access);
}

void HttpConnection::write(Response response) {
  response_ = std::move(response);
  http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code error, std::size_t) {
    if (error) return;
    if (self->response_.keep_alive()) {
      self->read();
      return;
    }
    beast::error_code ignored;
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

}  // namespace stroma::view
