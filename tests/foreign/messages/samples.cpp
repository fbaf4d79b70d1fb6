// SPDX-License-Identifier: Apache-2.0
//
// Usage: message_samples FILE. Writes random messages of every type as JSON: their definition, their bytes, and what
// the bytes should be read as. Numbers that JSON does not know are texts there: "nan", "inf", "-inf".
#include <array>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "../../messages/random_filler.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/definition.hpp"

namespace {

using namespace stereogrid::messages;

constexpr unsigned samples{40};

/// A message as JSON, from the list of its fields.
class JsonWriter {
 public:
  template <class T>
  void operator()(std::string_view name, const T& field) {
    text += text.back() == '{' ? "\"" : ",\"";
    text += std::string{name} + "\":";
    write(field);
  }
  template <Message M>
  void write(const M& message) {
    text += '{';
    message.visit_fields(*this);
    text += '}';
  }

  std::string text;

 private:
  void write(bool flag) { text += flag ? "true" : "false"; }
  void write(std::byte byte) { text += std::to_string(static_cast<int>(byte)); }
  template <Primitive T>
  void write(T number) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.17g", static_cast<double>(number));
    const bool is_json{digits[0] == '-' ? digits[1] <= '9' : digits[0] <= '9'};
    text += is_json ? digits.data() : "\"" + std::string{digits.data()} + "\"";
  }
  void write(const std::string& letters) { text += "\"" + letters + "\""; }  // letters only: see RandomFiller
  template <class T>
  void write(const std::vector<T>& elements) {
    write_all(elements);
  }
  template <class T, std::size_t n>
  void write(const std::array<T, n>& elements) {
    write_all(elements);
  }
  template <class Elements>
  void write_all(const Elements& elements) {
    text += '[';
    for (const auto& element : elements) {
      if (text.back() != '[') text += ',';
      write(element);
    }
    text += ']';
  }
};

std::string hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x", static_cast<unsigned>(byte));
    text += digits.data();
  }
  return text;
}

std::string json_text(std::string_view plain) {
  std::string text{"\""};
  for (const char letter : plain) text += letter == '\n' ? std::string{"\\n"} : std::string{letter};
  return text + "\"";
}

template <Message M>
void write_type(std::ostream& out) {
  out << "{\"type\":" << json_text(M::type_name) << ",\"definition\":" << json_text(definition_of<M>())
      << ",\"messages\":[";
  CdrWriter writer;
  for (unsigned seed{0}; seed < samples; ++seed) {
    M message;
    test::RandomFiller{seed}.fill(message);
    JsonWriter json;
    json.write(message);
    out << (seed == 0 ? "" : ",") << "{\"cdr\":\"" << hex(writer.encode(message)) << "\",\"value\":" << json.text
        << "}";
  }
  out << "]}";
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  std::ofstream out{argv[1]};
  out << "[";
  bool is_first{true};
  test::for_each_type([&]<Message M>(const M& /*type*/) {
    out << (is_first ? "" : ",\n");
    is_first = false;
    write_type<M>(out);
  });
  out << "]\n";
  return out.flush() ? 0 : 1;
}
