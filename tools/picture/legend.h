// SPDX-License-Identifier: LGPL-2.1-or-later
// The legend: what the colours mean, with round numbers and the unit.
#pragma once
#include <string>
#include <vector>

#include "tools/picture/canvas.h"
#include "tools/picture/picture_maker.h"

namespace stroma::picture {

/// A unit that suits the size of numbers: kPa for thousands of Pa, N for thousands of mN.
struct Scale {
  double factor = 1;  ///< of the given unit
  std::string unit;
};
Scale scaleFor(double largest, const std::string& unit);

/// The distance of round numbers (1, 2, 2.5 or 5 times a power of ten) of which at most `most` intervals fit.
double roundStep(double span, int most);

/// The range from round numbers to round numbers, all of it inside. Of one value alone: a range around it.
Range rounded(const Range& range);

/// Numbers with as many decimals as tell them apart, whatever they have in common: "20.000", "20.001".
std::vector<std::string> alike(const std::vector<double>& numbers);

class Legend {
 public:
  /// `extremes`: of the values; where they go beyond the range its ends are pointed. `note`: under the title, or empty.
  Legend(const ColourMap& map, const Range& range, const Range& extremes, const FieldWord& field, std::string note);

  int width(double letter_size) const;  ///< [pixels]
  void draw(Canvas& canvas, int x, int y, int height, double letter_size) const;
  std::string caption() const;                                      ///< "von Mises stress [kPa]"
  const std::vector<std::string>& texts() const { return texts_; }  ///< at the marks, upwards
  std::string summary() const;                                      ///< "von Mises stress 0 to 2.5 kPa"

 private:
  ColourMap map_;
  Range range_, extremes_;
  FieldWord field_;
  std::string note_;
  Scale scale_;
  std::vector<double> marks_;  ///< in the SI unit
  std::vector<std::string> texts_;
};

}  // namespace stroma::picture
