// SPDX-License-Identifier: LGPL-2.1-or-later
// What may stand in an attribute, in the terms that XML Schema and RELAX NG have in common: names for the types of values,
// each a choice of simple types. Patterns are those of XML Schema.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/data.h"

namespace stroma::command {

struct SchemaBound {
  std::string value;
  bool inclusive = true;
};

/// One way to write a value.
struct SchemaAlternative {
  enum class Kind { text, boolean, integer, real, words, pattern, list };
  Kind kind = Kind::text;
  std::optional<SchemaBound> min{}, max{};  ///< of integer and real
  std::vector<std::string> words{};         ///< one of them
  std::string pattern{};                    ///< of the value without white space around it, single spaces inside
  std::vector<SchemaAlternative> items{};   ///< of a list: what each word of it may be
};

/// A value is written in one of several ways. Values of equal name are equal.
struct SchemaValue {
  std::string name;  ///< an NCName that a validator's message can use: "real_above_0"
  std::vector<SchemaAlternative> alternatives;
};

/// What an attribute takes: its own type, with or without units, or a link to another attribute.
SchemaValue valueOf(const Data& data);

/// Any text.
SchemaValue textValue();
/// One of `words`; nothing else.
SchemaValue wordValue(std::string name, std::vector<std::string> words);
/// Words of `template`: of a list, or names of SOFA's matrices.
SchemaValue templateValue(const std::vector<std::string>& words);
/// What a Node takes, where links are not followed: "boolean", "real", or "gravity", which is a vector or acts along y. A
/// real may have to be above 0.
SchemaValue plainValue(const std::string& kind, bool positive = false);

}  // namespace stroma::command
