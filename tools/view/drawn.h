// SPDX-License-Identifier: LGPL-2.1-or-later
// What the view draws, under the names of tools/drawing.
#pragma once
#include "tools/drawing/body.h"

namespace stroma::view {

using drawing::Body;
using drawing::BodyLink;
using drawing::cellValues;
using drawing::Drawing;
using drawing::drawingOf;
using drawing::Field;
using drawing::segmentsOf;

}  // namespace stroma::view
