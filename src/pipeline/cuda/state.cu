// SPDX-License-Identifier: Apache-2.0
//
// State of the stages on a GPU between two frames.
#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <vector>

#include "pipeline/cuda/stages.hpp"

namespace stereogrid {

void CudaStages::exchange(StateArchive archive) {
  if (StateWriter* const* const writer{std::get_if<StateWriter*>(&archive)}) return save(**writer);
  load(*std::get<StateReader*>(archive));
}

void CudaStages::save(StateWriter& state) {
  cuda_.use();
  state(window_before_);
  device_.states[1 - now_].for_each_array([&]<class T>(T* on_device, std::size_t size) {
    std::vector<T> numbers(size);
    download(cuda_, on_device, size, numbers.data());
    synchronize();
    state(numbers);
  });
}

void CudaStages::load(StateReader& state) {
  cuda_.use();
  state(window_before_);
  const int capacity{device_.filter.capacity};
  device_.states[1 - now_].for_each_array([&]<class T>(T* on_device, std::size_t size) {
    std::vector<T> numbers;
    state(numbers);
    bool fits{numbers.size() == size};
    if constexpr (std::is_same_v<T, int>) {  // slots, and how many are used
      fits =
          fits && std::all_of(numbers.begin(), numbers.end(), [&](int slot) { return slot >= -1 && slot <= capacity; });
      fits = fits && std::none_of(numbers.begin(), numbers.end() - 2, [&](int slot) { return slot == capacity; });
    }
    state.require(fits);
    if (!fits) return;
    upload(cuda_, numbers.data(), size, on_device);
    synchronize();
  });
}

}  // namespace stereogrid
