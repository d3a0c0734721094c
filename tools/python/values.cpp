// SPDX-License-Identifier: LGPL-2.1-or-later
// Values of attributes between the engine and Python.
#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tools/python/python.h"

namespace stroma::python {
namespace {

template <class T>
py::array copied(const T* numbers, std::vector<py::ssize_t> shape) {
  py::array_t<T> array(std::move(shape));
  if (array.size() > 0) std::memcpy(array.mutable_data(), numbers, sizeof(T) * std::size_t(array.size()));
  return array;
}

struct ToPython {
  bool found;
  py::object operator()(const bool* value) const { return py::bool_(*value); }
  py::object operator()(const int* value) const { return py::int_(*value); }
  py::object operator()(const double* value) const { return py::float_(*value); }
  py::object operator()(const std::string* value) const { return py::str(*value); }
  py::object operator()(const Vec3* value) const { return copied(value->data(), {3}); }
  template <class T, std::size_t n>
  py::object operator()(const std::array<T, n>* value) const {
    return copied(value->data(), {py::ssize_t(n)});
  }
  py::object operator()(const std::vector<bool>* value) const {
    py::array_t<bool> array(py::ssize_t(value->size()));
    for (std::size_t i = 0; i < value->size(); ++i) array.mutable_data()[i] = (*value)[i];
    return array;
  }
  template <class T>
  py::object operator()(const std::vector<T>* value) const {
    const auto count = py::ssize_t(value->size());
    if constexpr (std::is_arithmetic_v<T>) {
      return copied(value->data(), {count});
    } else if constexpr (std::is_same_v<T, Vec3>) {
      static_assert(sizeof(Vec3) == 3 * sizeof(double));
      return copied(reinterpret_cast<const double*>(value->data()), {count, 3});
    } else {
      return copied(reinterpret_cast<const Index*>(value->data()), {count, py::ssize_t(std::tuple_size_v<T>)});
    }
  }
  py::object operator()(const std::vector<std::string>* value) const {
    py::list list;
    for (const std::string& word : *value) list.append(word);
    return list;
  }
  py::object operator()(const FileName* value) const { return py::str(found ? value->found : value->given); }
  py::object operator()(const ChoiceRef& value) const { return py::str(value.words[std::size_t(*value.value)]); }
  py::object operator()(const LinkBase* value) const { return py::str(linkText(*value)); }
};

/// Of numpy and of plain Python alike.
bool isReal(py::handle value) { return PyFloat_Check(value.ptr()); }

std::string textOfArray(const py::array& array);

std::string textOfScalar(py::handle value) {
  if (PyBool_Check(value.ptr())) return value.ptr() == Py_True ? "true" : "false";
  if (PyLong_Check(value.ptr())) return py::str(value);
  if (isReal(value)) return fmt::format("{}", value.cast<double>());
  throw py::type_error("a value of a scene is a number, a text, a list or an array of them, not " +
                       std::string(py::str(py::type::of(value).attr("__name__"))));
}

std::string textOfArray(const py::array& array) {
  const char kind = array.dtype().kind();
  fmt::memory_buffer text;
  const auto print = [&](const auto* numbers) {
    for (py::ssize_t i = 0; i < array.size(); ++i) fmt::format_to(std::back_inserter(text), "{}{}", i ? " " : "", numbers[i]);
  };
  if (kind == 'f') {
    print(py::array_t<double, py::array::c_style | py::array::forcecast>(array).data());
  } else if (kind == 'i' || kind == 'u') {
    print(py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>(array).data());
  } else if (kind == 'b') {
    print(py::array_t<bool, py::array::c_style | py::array::forcecast>(array).data());
  } else {
    return textOf(array.attr("tolist")());
  }
  return fmt::to_string(text);
}

/// Memory of a value together with what declares it.
template <class T>
struct Owned {
  T value;
  Data data{"the array", &value};
};

template <class T>
std::shared_ptr<const Data> owned(std::vector<T> numbers) {
  auto kept = std::make_shared<Owned<std::vector<T>>>();
  kept->value.swap(numbers);
  return std::shared_ptr<const Data>(kept, &kept->data);
}

constexpr py::ssize_t few = 64;  ///< numbers that are as well written as text

}  // namespace

py::object valueOf(const Data& data, bool found) { return std::visit(ToPython{found}, data.pointer()); }

std::string linkText(const LinkBase& link) {
  if (!link.target() || link.takesMany()) return link.path;
  return link.target()->path();
}

std::string textOf(py::handle value) {
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::isinstance<py::array>(value)) return textOfArray(py::reinterpret_borrow<py::array>(value));
  if (py::hasattr(value, "__fspath__")) return py::str(value.attr("__fspath__")());
  if (py::hasattr(value, "dtype") && py::hasattr(value, "item")) return textOf(value.attr("item")());  // one of numpy's numbers
  if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value) || PyRange_Check(value.ptr())) {
    std::string text;
    bool first = true;
    for (const py::handle item : py::reinterpret_borrow<py::object>(value)) {
      text += (first ? "" : " ") + textOf(item);
      first = false;
    }
    return text;
  }
  return textOfScalar(value);
}

std::shared_ptr<const Data> typedOf(py::handle value) {
  if (!py::isinstance<py::array>(value)) return nullptr;
  const auto array = py::reinterpret_borrow<py::array>(value);
  const char kind = array.dtype().kind();
  if (array.size() <= few) return nullptr;
  if (kind == 'f') {
    const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(array);
    std::vector<double> out(numbers.data(), numbers.data() + numbers.size());
    for (const double number : out)
      if (!std::isfinite(number)) return nullptr;
    return owned(std::move(out));
  }
  if (kind != 'i' && kind != 'u') return nullptr;
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> numbers(array);
  std::vector<int> out;
  out.reserve(std::size_t(numbers.size()));
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    const std::int64_t number = numbers.data()[i];
    if (number < 0 || number > std::numeric_limits<Index>::max()) return nullptr;
    out.push_back(int(number));
  }
  return owned(std::move(out));
}

}  // namespace stroma::python
