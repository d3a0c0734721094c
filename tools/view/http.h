// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>

namespace stroma::view {

class Server;

/// One connection of a browser: it is given the files of the page, or becomes the websocket of a page.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;
  HttpConnection(Server& server, boost::asio::ip::tcp::socket socket);
  ~HttpConnection();

  void start() { read(); }

 private:
  void read();
  void taken();
  bool namesUs(const Request& request) const;
  /// The socket becomes that of somebody who counts it himself.
  boost::asio::ip::tcp::socket release();
  Response answer(const Request& request) const;
  Response page(const Request& request) const;
  void write(Response response);

  Server& server_;
  std::string local_;  ///< address of this machine that the browser has connected to
  boost::beast::tcp_stream stream_;
  bool is_counted_ = true;
  boost::beast::flat_buffer buffer_{16 << 10};
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  Response response_;
};

}  // namespace stroma::view
