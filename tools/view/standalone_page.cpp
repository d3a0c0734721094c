// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/view/standalone_page.h"

#include <zlib.h>

#include <array>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "tools/view/page_files.h"

namespace stroma::view {
namespace {

/// A browser unpacks a part at a time.
constexpr std::size_t most_part_bytes = 64u << 20;

std::string base64(std::string_view bytes) {
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

/// Whole packets as one gzip stream.
class StandalonePage::Part {
 public:
  Part() {
    constexpr int gzip = 15 + 16;
    if (deflateInit2(&stream_, Z_BEST_COMPRESSION, Z_DEFLATED, gzip, 9, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::runtime_error("the page cannot be compressed: zlib does not start");
  }
  ~Part() { deflateEnd(&stream_); }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  void add(std::string_view bytes) {
    given_ += bytes.size();
    constexpr std::size_t most = 1u << 30;  // zlib counts in 32 bits
    for (; bytes.size() > most; bytes.remove_prefix(most)) compress(bytes.substr(0, most), Z_NO_FLUSH);
    compress(bytes, Z_NO_FLUSH);
  }
  std::string finish() {
    compress({}, Z_FINISH);
    return base64(out_);
  }
  std::size_t given() const { return given_; }
  std::size_t size() const { return (out_.size() + 2) / 3 * 4; }

 private:
  void compress(std::string_view bytes, int flush) {
    std::array<char, 1 << 16> piece;
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream_.avail_in = uInt(bytes.size());
    int end = Z_OK;
    do {
      stream_.next_out = reinterpret_cast<Bytef*>(piece.data());
      stream_.avail_out = uInt(piece.size());
      end = deflate(&stream_, flush);
      out_.append(piece.data(), piece.size() - stream_.avail_out);
    } while (stream_.avail_out == 0);
    if (stream_.avail_in != 0 || (flush == Z_FINISH && end != Z_STREAM_END))
      throw std::runtime_error("the page cannot be compressed");
  }

  z_stream stream_{};
  std::string out_;
  std::size_t given_ = 0;
};

StandalonePage::StandalonePage()
    : without_parts_(pageFile("/")->content.size() + pageFile("/app.css")->content.size() +
                     pageFile("/app.js")->content.size()) {}
StandalonePage::~StandalonePage() = default;

void StandalonePage::add(std::string_view packet) {
  if (packet.size() > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("a frame of this scene has more than 4 GiB: too much for a page");
  if (!part_) part_ = std::make_unique<Part>();
  const auto length = std::uint32_t(packet.size());
  part_->add({reinterpret_cast<const char*>(&length), sizeof length});
  part_->add(packet);
  if (part_->given() < most_part_bytes) return;
  parts_ += (parts_.empty() ? "\"" : ",\"") + part_->finish() + "\"";
  part_.reset();
}

std::size_t StandalonePage::size() const { return without_parts_ + parts_.size() + (part_ ? part_->size() : 0); }

std::string StandalonePage::finish() {
  if (part_) parts_ += (parts_.empty() ? "\"" : ",\"") + part_->finish() + "\"";
  part_.reset();
  std::string page(pageFile("/")->content);
  replaceOnce(page, R"(<link rel="stylesheet" href="app.css">)",
              "<style>" + std::string(pageFile("/app.css")->content) + "</style>");
  replaceOnce(page, R"(<script src="app.js"></script>)",
              "<script type=\"application/json\" id=\"stroma-recording\">{\"packets\":[" + parts_ +
                  "]}</script>\n<script>" + inScript(pageFile("/app.js")->content) + "</script>");
  return page;
}

}  // namespace stroma::view
