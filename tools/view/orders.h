// SPDX-License-Identifier: LGPL-2.1-or-later
// Reading what pages send: every value is checked, and what is wrong is a sentence.
#pragma once
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "framework/scene/diagnostics.h"
#include "framework/scene/types.h"

namespace stroma::view {

/// What the message asks for. Throws ComponentError for a verb that there is not, and for members that it does not have: a
/// misspelt one would be ignored silently.
std::string checkedVerb(const nlohmann::json& order);

/// With what was expected, and the nearest right name.
std::string sentenceOf(const ComponentError& error);

/// Whether the page that asks for this must have control: it changes the run, or how it is shown.
bool needsControl(const std::string& verb);

/// A page that comes or goes: the server's own order, which never waits.
inline bool isOfServer(const nlohmann::json& order) {
  const std::string verb = order.value("do", "");
  return verb == "attach" || verb == "leave";
}

/// A member of a message that has to be there.
inline const nlohmann::json& member(const nlohmann::json& order, const char* name) {
  const auto found = order.find(name);
  if (found == order.end()) throw ComponentError(std::string("the message has no '") + name + "'");
  return *found;
}

inline double number(const nlohmann::json& value, const char* name, double low, double high) {
  if (!value.is_number() || !std::isfinite(value.get<double>()) || value.get<double>() < low ||
      value.get<double>() > high)
    throw ComponentError(std::string("'") + name + "' is " + value.dump().substr(0, 40),
                         "a number from " + nlohmann::json(low).dump() + " to " + nlohmann::json(high).dump());
  return value.get<double>();
}

inline long integer(const nlohmann::json& value, const char* name, long low, long high) {
  const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <= std::uint64_t(high)
                                               : value.is_number_integer() && value.get<std::int64_t>() <= high;
  if (!fits || value.get<std::int64_t>() < low)
    throw ComponentError(std::string("'") + name + "' is " + value.dump().substr(0, 40),
                         "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return long(value.get<std::int64_t>());
}

inline std::string text(const nlohmann::json& value, const char* name, std::size_t longest) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > longest)
    throw ComponentError(std::string("'") + name + "' is no text of at most " + std::to_string(longest) +
                         " characters");
  return value.get<std::string>();
}

inline Vec3 place(const nlohmann::json& value, const char* name) {
  if (!value.is_array() || value.size() != 3) throw ComponentError(std::string("'") + name + "' is not three numbers");
  Vec3 out;
  for (int k = 0; k < 3; ++k) out[k] = number(value[std::size_t(k)], name, -1e9, 1e9);
  return out;
}

}  // namespace stroma::view
