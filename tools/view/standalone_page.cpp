// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/standalone_page.h"

#include <zlib.h>

#include <cstdint>
#include <stdexcept>

#include "tools/view/page_files.h"

namespace stroma::view {
namespace {

std::string compressed(const std::string& bytes) {
  z_stream stream{};
  constexpr int gzip = 15 + 16;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, gzip, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("the page cannot be compressed: zlib does not start");
  std::string out(deflateBound(&stream, uLong(bytes.size())) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(out.size());
  const int end = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (end != Z_STREAM_END) throw std::runtime_error("the page cannot be compressed");
  return out;
}

std::string base64(const std::string& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

void replaceOnce(std::string& text, std::string_view what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("index.html has no " + std::string(what));
  text.replace(at, what.size(), by);
}

/// Inside of an element `script` its end must not be written out.
std::string inScript(std::string_view script) {
  std::string out(script);
  for (std::size_t at = out.find("</script"); at != std::string::npos; at = out.find("</script", at + 3))
    out.replace(at, 2, "<\\/");
  return out;
}

}  // namespace

std::string standalonePage(const std::vector<std::string>& packets) {
  std::string bytes;
  for (const std::string& packet : packets) {
    const auto length = std::uint32_t(packet.size());
    bytes.append(reinterpret_cast<const char*>(&length), sizeof length);
    bytes += packet;
  }
  std::string page(pageFile("/")->content);
  replaceOnce(page, R"(<link rel="stylesheet" href="app.css">)",
              "<style>" + std::string(pageFile("/app.css")->content) + "</style>");
  replaceOnce(page, R"(<script src="app.js"></script>)",
              "<script type=\"application/json\" id=\"stroma-recording\">{\"packets\":[\"" + base64(compressed(bytes)) +
                  "\"]}</script>\n<script>" + inScript(pageFile("/app.js")->content) + "</script>");
  return page;
}

}  // namespace stroma::view
