// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <functional>
#include <memory>

#include "stereogrid/image.hpp"

namespace stereogrid {

/// Throws DeviceError with CUDA's text: "could not `doing`: …".
void check_cuda(cudaError_t status, const char* doing);

/// Observer of kernels, called before and after each launch. For measurements.
class LaunchWatch {
 public:
  virtual void begin(cudaStream_t stream, const void* kernel) = 0;
  virtual void end(cudaStream_t stream) = 0;

 protected:
  ~LaunchWatch() = default;
};

/// The CUDA back end: one device, and a stream that all its work goes through.
class Cuda {
 public:
  /// `device` counts from 0; it is the calling thread's current one from then on. Throws DeviceError: no such device, a
  /// driver or a device too old, or one that this build has no code for.
  explicit Cuda(int device = 0);
  Cuda(const Cuda&) = delete;
  Cuda& operator=(const Cuda&) = delete;
  ~Cuda();

  /// Makes the device the calling thread's current one, which it must be for all calls of CUDA.
  void use() const;
  [[nodiscard]] cudaStream_t stream() const { return stream_; }
  [[nodiscard]] int multiprocessors() const { return multiprocessors_; }
  /// Waits for all work given so far; throws DeviceError where some of it failed.
  void synchronize();
  /// Loads the kernels that `work` starts; nothing is done. Without, a kernel is loaded, or even compiled for this
  /// device, when it is started for the first time.
  void load(const std::function<void()>& work);
  [[nodiscard]] bool is_loading() const { return is_loading_; }
  /// Sets the observer of all further kernels; null: none.
  void watch(LaunchWatch* watch) { watch_ = watch; }
  [[nodiscard]] LaunchWatch* launch_watch() const { return watch_; }

 private:
  int device_;
  cudaStream_t stream_{};
  cudaEvent_t idle_{};
  bool is_loading_{false};
  int multiprocessors_{0};
  LaunchWatch* watch_{nullptr};
};

/// Flags of events that the host waits for. Where cores are few, or share power and memory with the GPU, the waiting
/// thread sleeps; elsewhere it spins, which returns some 10 us earlier.
constexpr unsigned wait_flags(unsigned cores, bool is_integrated) {
  return cores <= 8 || is_integrated ? cudaEventBlockingSync : cudaEventDefault;
}
/// An event that the host can wait for, with the flags for this machine and the current device.
cudaEvent_t create_event();

/// Throws DeviceError where the kernel cannot be loaded.
void load_kernel(const void* kernel);

/// Memory on the device: undefined, or all bits 0. Throws DeviceError where there is too little.
void* allocate_on_device(std::size_t bytes);
void* allocate_cleared_on_device(std::size_t bytes);
/// Memory of the host, all bits 0, that the device can copy from and to while both work.
void* allocate_pinned(std::size_t bytes);

/// Bytes allocated by this thread so far, freed or not.
struct CudaBytes {
  std::size_t device{0};
  std::size_t pinned{0};

  friend CudaBytes operator-(CudaBytes a, CudaBytes b) { return {a.device - b.device, a.pinned - b.pinned}; }
};
CudaBytes cuda_bytes_allocated();

struct DeviceDeleter {
  void operator()(void* memory) const { cudaFree(memory); }
};
struct PinnedDeleter {
  void operator()(void* memory) const { cudaFreeHost(memory); }
};

/// `size` elements on the device, all bits 0 at construction.
template <class T>
class DeviceBuffer {
 public:
  explicit DeviceBuffer(std::size_t size)
      : data_{static_cast<T*>(allocate_cleared_on_device(size * sizeof(T)))}, size_{size} {}

  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::unique_ptr<T[], DeviceDeleter> data_;
  std::size_t size_;
};

/// width × height elements on the device, rows without gaps. Unwritten elements are undefined.
template <class T>
class DeviceImage {
 public:
  DeviceImage(int width, int height) : width_{width}, height_{height} {
    own_.reset(static_cast<T*>(allocate_on_device(size() * sizeof(T))));
    data_ = own_.get();
  }
  /// Uses foreign memory.
  DeviceImage(int width, int height, T* memory) : data_{memory}, width_{width}, height_{height} {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] View<T, Device> view() { return {data(), width_, height_, width_}; }
  [[nodiscard]] View<const T, Device> view() const { return {data(), width_, height_, width_}; }

 private:
  std::unique_ptr<T[], DeviceDeleter> own_;
  T* data_{nullptr};
  int width_;
  int height_;
};

/// `size` elements of pinned host memory, all bits 0 at construction.
template <class T>
class PinnedBuffer {
 public:
  explicit PinnedBuffer(std::size_t size) : data_{static_cast<T*>(allocate_pinned(size * sizeof(T)))}, size_{size} {}

  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::unique_ptr<T[], PinnedDeleter> data_;
  std::size_t size_;
};

/// Copies in the stream's order; nothing for size 0, which a graph rejects. The host's memory must stay unchanged until
/// the stream has passed the copy.
template <class T>
void upload(Cuda& cuda, const T* host, std::size_t count, T* device) {
  if (count == 0 || cuda.is_loading()) return;
  check_cuda(cudaMemcpyAsync(device, host, count * sizeof(T), cudaMemcpyHostToDevice, cuda.stream()),
             "copy to the device");
}
template <class T>
void download(Cuda& cuda, const T* device, std::size_t count, T* host) {
  if (count == 0 || cuda.is_loading()) return;
  check_cuda(cudaMemcpyAsync(host, device, count * sizeof(T), cudaMemcpyDeviceToHost, cuda.stream()),
             "copy from the device");
}
/// Sets all bits to 0.
template <class T>
void clear(Cuda& cuda, T* device, std::size_t count) {
  if (count == 0 || cuda.is_loading()) return;
  check_cuda(cudaMemsetAsync(device, 0, count * sizeof(T), cuda.stream()), "clear device memory");
}

/// Starts a kernel. `arguments` are converted to the kernel's parameters. A grid without blocks: nothing to do.
template <class... Parameters, class... Arguments>
void launch(Cuda& cuda, void (*kernel)(Parameters...), dim3 grid, dim3 block, std::size_t shared_bytes,
            Arguments... arguments) {
  if (cuda.is_loading()) return load_kernel(reinterpret_cast<const void*>(kernel));
  if (grid.x == 0 || grid.y == 0 || grid.z == 0) return;
  cudaLaunchConfig_t config{};
  config.gridDim = grid;
  config.blockDim = block;
  config.dynamicSmemBytes = shared_bytes;
  config.stream = cuda.stream();
  LaunchWatch* const watch{cuda.launch_watch()};
  if (watch != nullptr) watch->begin(cuda.stream(), reinterpret_cast<const void*>(kernel));
  check_cuda(cudaLaunchKernelEx(&config, kernel, static_cast<Parameters>(arguments)...), "start a kernel");
  if (watch != nullptr) watch->end(cuda.stream());
}

/// Work that is recorded once and then given to the device as a whole, again and again.
class Graph {
 public:
  Graph() = default;
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  ~Graph();

  [[nodiscard]] bool empty() const { return executable_ == nullptr; }
  /// Records the work that `work` enqueues, without running it. Replaces an earlier record.
  void capture(Cuda& cuda, const std::function<void()>& work);
  void launch(Cuda& cuda);

 private:
  cudaGraphExec_t executable_{};
};

/// Blocks of `block` threads that cover `count` elements.
constexpr unsigned blocks_for(int count, int block) {
  return count > 0 ? static_cast<unsigned>((count + block - 1) / block) : 0U;
}

/// Shared memory of the launch; the same for every T.
template <class T>
__device__ inline T* dynamic_shared() {
#if defined(__CUDACC__)
  extern __shared__ __align__(16) unsigned char stereogrid_dynamic_shared[];
  return reinterpret_cast<T*>(stereogrid_dynamic_shared);
#else
  return static_cast<T*>(emulator::dynamic_shared());
#endif
}

}  // namespace stereogrid
