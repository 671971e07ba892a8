#include "scene/live/midi.hpp"

namespace carillon::scene::live {

std::optional<Request> midi_request(std::span<const std::uint8_t> message, std::size_t objects,
                                    double hand) {
  if (message.size() != 3 || message[1] > 127 || message[2] > 127) return std::nullopt;
  const int kind = message[0] & 0xF0;
  const double value = message[2];
  Request request;
  if (kind == 0x90 && message[2] > 0) {
    const int key = message[1] - first_note;
    if (key < 0 || (objects > 1 && static_cast<std::size_t>(key) >= objects)) return std::nullopt;
    request.kind = Request::Kind::strike;
    request.object = objects == 1 ? "0" : std::to_string(key);
    if (objects == 1) request.place = key;
    request.strength = value / 100 * (value / 100);
    return request;
  }
  if (kind != 0xB0 || (message[1] != 1 && message[1] != 64)) return std::nullopt;
  request.kind = Request::Kind::damp;
  request.object = "*";
  request.amount = message[1] == 1 ? hand * value / 127 : (message[2] < 64 ? hand : 0);
  return request;
}

}  // namespace carillon::scene::live
