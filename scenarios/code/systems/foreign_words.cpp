#include "scenarios/code/systems/foreign_words.h"

#include <cstdint>

namespace gaitcam {
namespace {

/// Bytes of the character that `text` begins with (RFC 3629: none beyond U+10FFFF, no surrogate, none longer than it
/// need be); 0 if it begins with none.
size_t CharacterBytes(std::string_view text) {
  const auto byte = [&](size_t i) { return i < text.size() ? uint8_t(text[i]) : uint8_t(0); };
  const uint8_t first = byte(0);
  if (first < 0x80) return 1;
  const size_t bytes = first >= 0xc2 && first < 0xe0 ? 2 : first >= 0xe0 && first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  if (first < 0xc2 || bytes == 0) return 0;
  for (size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool is_long = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool is_surrogate = first == 0xed && byte(1) >= 0xa0, is_beyond = first == 0xf4 && byte(1) >= 0x90;
  return is_long || is_surrogate || is_beyond ? 0 : bytes;
}

}  // namespace

std::string ForeignWords(std::string_view said) {
  constexpr size_t kMost = 1000;
  constexpr char kDelete = 0x7f;
  std::string words;
  while (!said.empty()) {
    if (words.size() >= kMost) return words + "...";
    const size_t bytes = CharacterBytes(said);
    const bool is_control = bytes == 1 && (uint8_t(said[0]) < ' ' || said[0] == kDelete);
    const bool is_c1 = bytes == 2 && uint8_t(said[0]) == 0xc2 && uint8_t(said[1]) < 0xa0;
    if (bytes == 0 || is_control || is_c1) {
      words += said[0] == '\t' ? ' ' : '?';
    } else {
      words += said.substr(0, bytes);
    }
    said.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return words;
}

}  // namespace gaitcam
