// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/session/xml_text.h"
#include "tools/sweep/chart_scale.h"
#include "tools/sweep/report_files.h"

namespace stroma::sweep {
namespace {

constexpr double width = 812, height = 464, left = 100, right = 216, top = 46, bottom = 58;
constexpr std::size_t colours = 8;

/// Shapes differ too, for who does not tell the colours apart. Around (0 0), about 9 wide.
constexpr std::array<const char*, colours> markers{
    "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0-9 0z",
    "M-4-4h8v8h-8z",
    "M0-5.2L4.8 3.6h-9.6z",
    "M0-5.6L5 0 0 5.6-5 0z",
    "M0 5.2L4.8-3.6h-9.6z",
    "M-1.7-5h3.4v3.3h3.3v3.4h-3.3v3.3h-3.4v-3.3h-3.3v-3.4h3.3z",
    "M-5 0L-2.5-4.4h5L5 0 2.5 4.4h-5z",
    "M-4.6-4.6L0-1.6 4.6-4.6 1.6 0 4.6 4.6 0 1.6-4.6 4.6-1.6 0z",
};

class Drawing {
 public:
  Drawing(const Chart& chart, bool standalone, bool dark)
      : chart_(chart),
        standalone_(standalone),
        dark_(dark),
        x_(valuesOf(&ChartPoint::x), left, width - right),
        y_(valuesOf(&ChartPoint::y), height - bottom, top) {}

  std::string text() {
    const std::string sizes = standalone_ ? fmt::format(" width=\"{}\" height=\"{}\"", width, height) : "";
    out_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" id=\"{}\"{} viewBox=\"0 0 {} {}\" role=\"group\" "
        "aria-label=\"{}\">\n",
        chart_.id, sizes, width, height, xmlText(chart_.title));
    if (standalone_) out_ += "<style>" + chartStyle(dark_) + "</style>\n";
    out_ += fmt::format("<rect class=\"paper\" width=\"{}\" height=\"{}\"/>\n", width, height);
    axes();
    band();
    if (chart_.front.size() > 1) out_ += fmt::format("<path class=\"front\" d=\"{}\"/>\n", pathOf(chart_.front));
    for (const ChartLine& line : chart_.lines) drawLine(line);
    crosses();
    labels();
    return out_ + "</svg>\n";
  }

 private:
  std::vector<double> valuesOf(double ChartPoint::*value) const {
    std::vector<double> values;
    for (const ChartLine& line : chart_.lines)
      for (const ChartPoint& point : line.points)
        values.push_back(value == &ChartPoint::y ? std::max(point.y, chart_.least) : point.*value);
    if (value == &ChartPoint::x)
      for (const ChartPoint& point : chart_.without) values.push_back(point.x);
    return values;
  }

  std::string pathOf(const std::vector<ChartPoint>& points) const {
    std::string path;
    for (const ChartPoint& point : points)
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_.at(point.x), y_.at(point.y));
    return path;
  }

  void put(const char* style, double x, double y, const std::string& text, const char* anchor = "middle",
           const std::string& more = "") {
    out_ += fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", style, x, y,
                        anchor, more, xmlText(text));
  }

  void axes() {
    std::string fine, coarse;
    for (const LogScale::Mark& mark : x_.marks())
      (mark.has_label ? coarse : fine) += fmt::format("M{:.1f} {}V{}", x_.at(mark.value), top, height - bottom);
    for (const LogScale::Mark& mark : y_.marks())
      (mark.has_label ? coarse : fine) += fmt::format("M{} {:.1f}H{}", left, y_.at(mark.value), width - right);
    out_ += fmt::format("<path class=\"grid fine\" d=\"{}\"/>\n<path class=\"grid\" d=\"{}\"/>\n", fine, coarse);
    out_ += fmt::format("<path class=\"axis\" d=\"M{} {}V{}H{}\"/>\n", left, top, height - bottom, width - right);
    double last = -1e9;
    for (const LogScale::Mark& mark : x_.marks()) {
      const double x = x_.at(mark.value);
      if (!mark.has_label || x - last < 44) continue;
      put("tick", x, height - bottom + 18, numberText(mark.value, chart_.x_numbers));
      last = x;
    }
    last = 1e9;
    for (const LogScale::Mark& mark : y_.marks()) {
      const double y = y_.at(mark.value);
      if (!mark.has_label || last - y < 16) continue;
      put("tick", left - 8, y + 4, numberText(mark.value, chart_.y_numbers), "end");
      last = y;
    }
    put("title", left, top - 22, chart_.title, "start");
    put("name", (left + width - right) / 2, height - 14, chart_.x_label);
    const double middle = (top + height - bottom) / 2;
    put("name", 18, middle, chart_.y_label, "middle", fmt::format(" transform=\"rotate(-90 18 {})\"", middle));
  }

  /// Errors that cannot be told from the reference's own.
  void band() {
    if (!(chart_.uncertainty > 0) || chart_.uncertainty < y_.low()) return;
    const double y = y_.at(chart_.uncertainty);
    out_ += fmt::format("<rect class=\"band\" x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\"/>\n", left, y,
                        width - right - left, height - bottom - y);
    put("note", left + 8, height - bottom - 7, chart_.uncertainty_text, "start");
  }

  void drawLine(const ChartLine& line) {
    const std::size_t colour = line.colour % colours;
    out_ += fmt::format("<g class=\"series s{}\">", colour);
    if (line.points.size() > 1) out_ += fmt::format("<path class=\"line\" d=\"{}\"/>", pathOf(line.points));
    for (const ChartPoint& point : line.points) {
      const std::string kind =
          std::string(point.on_front ? " on-front" : "") + (point.is_reference ? " is-reference" : "");
      out_ += fmt::format(
          "<g class=\"point{}\" data-entry=\"{}\" transform=\"translate({:.1f} {:.1f})\"><circle class=\"halo\" "
          "r=\"9\"/>"
          "<path class=\"mark\" d=\"{}\"/></g>",
          kind, point.entry, x_.at(point.x), y_.at(point.y), markers[colour]);
    }
    out_ += "</g>\n";
  }

  void crosses() {
    for (const ChartPoint& point : chart_.without)
      out_ += fmt::format(
          "<g class=\"point without\" data-entry=\"{}\" transform=\"translate({:.1f} {:.1f})\"><circle class=\"halo\" "
          "r=\"9\"/><path class=\"mark\" d=\"M-4-4L4 4M-4 4L4-4\"/></g>\n",
          point.entry, x_.at(point.x), top + 8);
  }

  /// At the ends of their lines, moved apart where they would overlap.
  void labels() {
    struct Label {
      double wanted, y;
      const ChartLine* line;
    };
    std::vector<Label> labels;
    for (const ChartLine& line : chart_.lines)
      if (!line.label.empty() && !line.points.empty()) {
        const double y = y_.at(line.points.back().y);
        labels.push_back({y, y, &line});
      }
    const double room = height - bottom - top;
    const double step = std::min(17.0, room / std::max<double>(1, double(labels.size())));
    std::ranges::stable_sort(labels, {}, &Label::wanted);
    for (std::size_t i = 0; i < labels.size(); ++i)
      labels[i].y = i == 0 ? labels[i].wanted : std::max(labels[i].wanted, labels[i - 1].y + step);
    for (std::size_t i = labels.size(); i-- > 0;)
      labels[i].y = std::min(labels[i].y, i + 1 == labels.size() ? height - bottom : labels[i + 1].y - step);
    for (const Label& label : labels) {
      const double from = x_.at(label.line->points.back().x) + 9, to = width - right + 12;
      const std::size_t colour = label.line->colour % colours;
      out_ += fmt::format("<path class=\"leader s{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>", colour, from, label.wanted,
                          to, label.y);
      out_ += fmt::format(
          "<g class=\"series s{}\" transform=\"translate({:.1f} {:.1f}) scale(.8)\"><path class=\"mark\" "
          "d=\"{}\"/></g>",
          colour, to + 7, label.y, markers[colour]);
      put(fmt::format("label s{}", colour).c_str(), to + 16, label.y + 4, shortened(label.line->label), "start");
    }
  }

  static std::string shortened(const std::string& text) {
    constexpr std::size_t most = 26;
    if (text.size() <= most) return text;
    std::size_t end = most - 1;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;  // not within a character
    return text.substr(0, end) + "\u2026";
  }

  const Chart& chart_;
  bool standalone_, dark_;
  LogScale x_, y_;
  std::string out_;
};

std::string digits(double value) { return fmt::format("{:.3g}", value); }

}  // namespace

std::string numberText(double value, Numbers numbers) {
  struct Unit {
    double size;
    const char* name;
  };
  const auto scaled = [&](std::initializer_list<Unit> units) {
    for (const Unit& unit : units)
      if (std::abs(value) >= 0.9995 * unit.size) return digits(value / unit.size) + " " + unit.name;
    return digits(value / std::prev(units.end())->size) + " " + std::prev(units.end())->name;
  };
  if (numbers == Numbers::share) return digits(100 * value) + " %";
  if (numbers == Numbers::seconds) return scaled({{3600, "h"}, {60, "min"}, {1, "s"}, {1e-3, "ms"}, {1e-6, "µs"}});
  if (numbers == Numbers::metres) return scaled({{1, "m"}, {1e-3, "mm"}, {1e-6, "µm"}});
  return digits(value);
}

std::string svgOf(const Chart& chart, bool standalone, bool dark) { return Drawing(chart, standalone, dark).text(); }

}  // namespace stroma::sweep
