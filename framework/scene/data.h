// SPDX-License-Identifier: LGPL-2.1-or-later
// The parameters of a component, declared once. The same table parses and checks attributes, handles overrides and
// links, and prints the manual. Numerical code sees plain members; only the loader sees the table.
#pragma once
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "framework/scene/diagnostics.h"
#include "framework/scene/types.h"

namespace stroma {

class Component;
class LinkBase;

/// A file named in a scene. `given` as written; `found` the full path after searching the scene's folder, then
/// STROMA_DATA_PATH, then SOFA_DATA_PATH. An output file is not searched: `found` is `given` made absolute.
struct FileName {
  std::string given;
  std::string found;
  bool empty() const { return given.empty(); }
};

/// An enumeration in a scene: `value` points to the member (as int), `words[i]` is the word for the value i.
struct ChoiceRef {
  int* value = nullptr;
  std::vector<std::string> words;
};

/// Every type an attribute can have. A new type is added here, in the parser and in the printer (data.cpp).
using DataPointer =
    std::variant<bool*, int*, double*, std::string*, Vec3*, std::array<int, 3>*, std::array<double, 16>*,
                 std::vector<bool>*, std::vector<int>*, std::vector<double>*, std::vector<Vec3>*,
                 std::vector<std::string>*, std::vector<Edge>*, std::vector<Triangle>*, std::vector<Quad>*,
                 std::vector<std::array<Index, 6>>*, std::vector<std::array<Index, 5>>*, std::vector<Hexahedron>*,
                 std::vector<QuadraticTetrahedron>*, FileName*, ChoiceRef, LinkBase*>;

/// Where the value of an attribute came from.
enum class DataOrigin { by_default, written, linked, by_override };

/// What it takes to change an attribute in a running scene.
enum class ChangeEffect {
  restart,    ///< the scene must be loaded again with the new value; the default
  at_once,    ///< steps read the member itself: the next step uses the new value
  recompile,  ///< Component::recompile() recomputes what was derived from it; nothing else is loaded again
};

/// One attribute. Filled by the fluent calls below inside Component::declare().
class Data {
 public:
  Data(std::string name, DataPointer pointer);

  // ---- declaration (each returns *this) ----
  Data& help(std::string text);                    ///< one line; every attribute has one
  Data& unit(std::string text);                    ///< "Pa", "m", "s"; "-" for a pure number
  Data& unitOrNumber(const std::string& text);     ///< one of both, see settleUnit()
  Data& alias(std::string other);                  ///< another accepted name (SOFA's)
  Data& min(double value, bool inclusive = true);  ///< applies to every number of the value
  Data& max(double value, bool inclusive = true);
  Data& required();    ///< an error if it is missing
  Data& physical();    ///< a warning that states the default if it is missing
  Data& output();      ///< computed by the component: it can be linked, but not written
  Data& ofNodes() { return of_nodes_ = true, *this; }  ///< a list with a value for each node of the component's state
  Data& ofCells(std::size_t width = 1) { return cell_width_ = width, *this; }  ///< a list that may have `width` numbers per cell
  Data& input();       ///< FileName only: the file must exist
  Data& shorthand();   ///< an abbreviation of another attribute; not in the main table of the manual
  Data& atOnce();      ///< ChangeEffect::at_once
  Data& recompiled();  ///< ChangeEffect::recompile
  Data& inValuesOf(std::size_t numbers);  ///< a flat list: how many numbers form one value; copyFrom() splits none

  // ---- use ----
  const std::string& name() const { return name_; }
  const std::vector<std::string>& aliases() const { return aliases_; }
  const std::string& helpText() const { return help_; }
  const std::string& unitText() const { return unit_; }
  /// Of unitOrNumber() what is meant, once that is known. False: values were written in another unit.
  bool settleUnit(const std::string& text);
  bool isRequired() const { return required_; }
  bool isPhysical() const { return physical_; }
  bool isOutput() const { return output_; }
  bool isOfNodes() const { return of_nodes_; }
  std::size_t cellWidth() const { return cell_width_; }  ///< 0: not per cell
  bool isInputFile() const { return input_; }
  bool isShorthand() const { return shorthand_; }
  ChangeEffect changeEffect() const { return change_effect_; }
  bool isSet() const { return origin_ != DataOrigin::by_default; }
  DataOrigin origin() const { return origin_; }
  const DataPointer& pointer() const { return pointer_; }
  void keepIn(DataPointer pointer);  ///< another member, before values are read
  LinkBase* link() const;        ///< not null for an attribute that names a component
  std::string typeText() const;  ///< "list of 3 reals", "one of: small, large"
  std::string defaultText() const { return default_; }
  std::string rangeText() const;  ///< "[0, 0.5)" or empty

  /// Parses `text` into the member. On failure the member keeps its value, and the returned problem has message,
  /// expected and suggestion (the caller adds location and path).
  [[nodiscard]] std::optional<Problem> parse(std::string_view text, DataOrigin origin);
  /// Copies the value of another attribute (a data link); converts between lists of numbers of equal meaning
  /// (one value to a list of one, flat reals to Vec3 and back).
  [[nodiscard]] std::optional<Problem> copyFrom(const Data& source);
  /// The value in the scene's notation; reals with the digits that read back to the same bits.
  std::string print() const;

 private:
  friend class DataTable;
  std::optional<Problem> checkRange() const;
  void closeUnit(std::string_view written);

  std::string name_, help_, unit_, default_;
  std::vector<std::string> aliases_;
  DataPointer pointer_;
  double min_ = -std::numeric_limits<double>::infinity(), max_ = std::numeric_limits<double>::infinity();
  bool min_inclusive_ = true, max_inclusive_ = true;
  bool required_ = false, physical_ = false, output_ = false, input_ = false, shorthand_ = false, of_nodes_ = false;
  DataOrigin origin_ = DataOrigin::by_default;
  ChangeEffect change_effect_ = ChangeEffect::restart;
  std::size_t value_width_ = 0;  ///< 0: given by the type
  std::size_t cell_width_ = 0;
};

/// All attributes of a component, in the order of declaration.
class DataTable {
 public:
  /// Declares an attribute stored in `member`; its value at this moment is the default.
  template <class T>
  Data& add(std::string name, T& member) {
    return insert(Data(std::move(name), DataPointer(&member)));
  }
  /// Declares an enumeration stored in `member` (an enum with values 0, 1, ... in the order of `words`).
  template <class Enum>
  Data& addChoice(std::string name, Enum& member, std::vector<std::string> words) {
    static_assert(std::is_enum_v<Enum> && sizeof(Enum) == sizeof(int));
    return insert(Data(std::move(name), ChoiceRef{reinterpret_cast<int*>(&member), std::move(words)}));
  }
  /// Declares a link to another component.
  Data& addLink(std::string name, LinkBase& link);
  /// A SOFA attribute that only matters for drawing: accepted, listed in one line, without effect.
  void addVisualOnly(std::string name);

  Data* find(std::string_view name_or_alias);
  const Data* find(std::string_view name_or_alias) const;
  bool isVisualOnly(std::string_view name) const;
  std::vector<Data>& all() { return data_; }
  const std::vector<Data>& all() const { return data_; }
  std::vector<std::string> names() const;  ///< names and aliases, for suggestions

 private:
  Data& insert(Data data);
  std::vector<Data> data_;
  std::vector<std::string> visual_only_;
};

/// A link of a component to another one, by path ("@../mesh", "@loader"). Empty until resolved.
class LinkBase {
 public:
  virtual ~LinkBase() = default;
  /// False if `target` does not have the role that the link requires.
  virtual bool accepts(Component& target) const = 0;
  virtual std::string roleText() const = 0;  ///< "a mechanical state", for messages
  void set(Component* target) { target_ = target; }
  virtual bool takesMany() const { return false; }  ///< several paths, separated by spaces
  virtual void add(Component* target) { target_ = target; }
  Component* target() const { return target_; }
  std::string path;  ///< as written
  /// Words accepted instead of a path, for choices that need no separate component; `path` is then the word.
  std::vector<std::string> words;

 protected:
  Component* target_ = nullptr;
};

}  // namespace stroma
