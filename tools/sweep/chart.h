// SPDX-License-Identifier: LGPL-2.1-or-later
// A chart with logarithmic axes as SVG.
#pragma once
#include <string>
#include <vector>

namespace stroma::sweep {

struct ChartPoint {
  double x = 0, y = 0;
  std::size_t entry = 0;  ///< row of the table that it stands for
  bool on_front = false, is_reference = false;
};

/// Points that a line joins. Lines of one colour belong together; the label stands at the last point.
struct ChartLine {
  std::string label;
  std::size_t colour = 0;
  std::vector<ChartPoint> points;
};

/// How the numbers of an axis are written.
enum class Numbers { plain, share, seconds, metres };

struct Chart {
  std::string id, title, x_label, y_label;
  Numbers x_numbers = Numbers::plain, y_numbers = Numbers::plain;
  std::vector<ChartLine> lines;
  std::vector<ChartPoint> front;    ///< joined by a broad line
  std::vector<ChartPoint> without;  ///< no result: marked at the top edge, at their x
  double uncertainty = 0;           ///< of y: below it a band
  std::string uncertainty_text;     ///< in the band
  double least = 0;                 ///< of y: what lies below is drawn at the lower edge
};

/// `standalone`: a file of its own, with its colours in it. Otherwise the page that holds it gives the classes theirs.
/// `dark`: follows the reader's preference; renderers that know no such thing are given false.
std::string svgOf(const Chart& chart, bool standalone, bool dark);

/// "12 ms", "3.1 %"
std::string numberText(double value, Numbers numbers);

}  // namespace stroma::sweep
