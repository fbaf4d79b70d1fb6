// SPDX-License-Identifier: Apache-2.0
#include "runtime.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "fibers.hpp"

struct EmulatedGraph {
  std::vector<std::function<void()>> work;
};
struct EmulatedStream {
  EmulatedGraph* captured{nullptr};
};
struct EmulatedEvent {
  std::chrono::steady_clock::time_point when;
  bool is_of_graph{false};  ///< recorded by a node: it may still be that of the launch before, so waiting is an error
};

namespace {

bool lacks(const char* what) {
  const char* const lacking{std::getenv("STEREOGRID_EMULATOR_LACKS")};
  return lacking != nullptr && std::strcmp(lacking, what) == 0;
}

struct Machine {
  std::size_t memory{std::size_t{8} << 30};  ///< memory left to allocate
  std::unordered_map<void*, std::size_t> allocated;
  std::unordered_set<const void*> loaded;  ///< kernels
  int late{0};                             ///< kernels launched before they were loaded
  std::uint32_t unwritten{0};              ///< bits of the next allocation
  bool backwards{std::getenv("STEREOGRID_EMULATOR_BACKWARDS") != nullptr};
  std::atomic<int> captures{0};  ///< streams that are being captured
  std::recursive_mutex mutex;
};

thread_local int own_captures{0};         ///< number of this thread's `captures`
thread_local bool has_device_set{false};  ///< without, a GPU takes the first device

cudaError_t missing() {
  if (lacks("device")) return cudaErrorNoDevice;
  return lacks("driver") ? cudaErrorInsufficientDriver : cudaSuccess;
}

Machine& machine() {
  static Machine& the_machine{*new Machine};
  return the_machine;
}

// Loads a kernel. False: it had been loaded.
bool is_new(const void* kernel) {
  const std::lock_guard lock{machine().mutex};
  return machine().loaded.insert(kernel).second;
}

// Different in each allocation, so that results which depend on them differ.
std::uint32_t next_unwritten() {
  return emulator::unwritten | (machine().unwritten++ & 0xffU) << 8;
}

cudaError_t give(cudaStream_t stream, std::function<void()> work) {
  if (stream != nullptr && stream->captured != nullptr) {
    stream->captured->work.push_back(std::move(work));
  } else if (stream == nullptr && machine().captures > 0) {
    return cudaErrorStreamCaptureUnsupported;
  } else {
    const std::lock_guard lock{machine().mutex};
    work();
  }
  return cudaSuccess;
}

}  // namespace

namespace emulator {

cudaStream_t stream_per_thread() {
  thread_local EmulatedStream stream;
  return &stream;
}

namespace {

unsigned volume(dim3 size) {
  return size.x * size.y * size.z;
}

}  // namespace

void unload_kernels() {
  machine().loaded.clear();
  machine().late = 0;
}
int kernels_loaded_late() {
  return machine().late;
}

cudaError_t launch(const cudaLaunchConfig_t& config, const void* kernel, std::function<void()> thread) {
  constexpr unsigned threads_max{1024};
  constexpr unsigned blocks_max{65535};  // maximum of y and z
  constexpr std::size_t shared_max{std::size_t{48} << 10};
  if (volume(config.blockDim) == 0 || volume(config.blockDim) > threads_max || volume(config.gridDim) == 0 ||
      config.gridDim.y > blocks_max || config.gridDim.z > blocks_max || config.blockDim.z > 64) {
    return cudaErrorInvalidConfiguration;
  }
  if (config.dynamicSmemBytes > shared_max) return cudaErrorInvalidValue;
  if (is_new(kernel)) ++machine().late;
  return give(config.stream, [config, call = std::move(thread)] {
    run_grid(config.gridDim, config.blockDim, config.dynamicSmemBytes, call, machine().backwards);
  });
}

}  // namespace emulator

const char* cudaGetErrorString(cudaError_t status) {
  switch (status) {
    case cudaSuccess:
      return "no error";
    case cudaErrorInvalidValue:
      return "invalid argument";
    case cudaErrorMemoryAllocation:
      return "out of memory";
    case cudaErrorInvalidConfiguration:
      return "invalid configuration argument";
    case cudaErrorInsufficientDriver:
      return "CUDA driver version is insufficient for CUDA runtime version";
    case cudaErrorInvalidDeviceFunction:
      return "invalid device function";
    case cudaErrorNoKernelImageForDevice:
      return "no kernel image is available for execution on the device";
    case cudaErrorUnsupportedPtxVersion:
      return "the provided PTX was compiled with an unsupported toolchain";
    case cudaErrorNoDevice:
      return "no CUDA-capable device is detected";
    case cudaErrorStreamCaptureUnsupported:
      return "operation not permitted when stream is capturing";
  }
  return "unrecognized error code";
}
cudaError_t cudaGetLastError() {
  return cudaSuccess;
}

cudaError_t cudaGetDeviceCount(int* count) {
  *count = missing() == cudaSuccess ? 1 : 0;
  return missing();
}
cudaError_t cudaSetDevice(int /*device*/) {
  has_device_set = true;
  return missing();
}
cudaError_t cudaGetDevice(int* device) {
  *device = 0;
  return missing();
}
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int /*device*/) {
  *value = attribute == cudaDevAttrMultiProcessorCount      ? 2
           : attribute == cudaDevAttrIntegrated             ? 0
           : attribute == cudaDevAttrComputeCapabilityMajor ? 7
                                                            : 5;
  return missing();
}
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int /*device*/) {
  *properties = {"emulated", 2, 7, 5, machine().memory};
  return missing();
}
cudaError_t cudaFuncGetAttributes(cudaFuncAttributes* /*attributes*/, const void* kernel) {
  is_new(kernel);
  return lacks("kernels") ? cudaErrorNoKernelImageForDevice : cudaSuccess;
}
cudaError_t cudaDriverGetVersion(int* version) {
  *version = missing() == cudaErrorInsufficientDriver ? 10000 : CUDART_VERSION;
  return cudaSuccess;
}
cudaError_t cudaDeviceSynchronize() {
  return machine().captures > 0 ? cudaErrorStreamCaptureUnsupported : cudaSuccess;
}

cudaError_t cudaMalloc(void** memory, std::size_t bytes) {
  if (own_captures > 0) return cudaErrorStreamCaptureUnsupported;
  const std::lock_guard lock{machine().mutex};
  constexpr std::size_t little{std::size_t{1} << 14};
  if (bytes > (lacks("memory") ? little : machine().memory)) return cudaErrorMemoryAllocation;
  *memory = std::malloc(bytes);
  emulator::fill_unwritten(*memory, bytes, next_unwritten());
  machine().memory -= bytes;
  machine().allocated[*memory] = bytes;
  return cudaSuccess;
}
cudaError_t cudaFree(void* memory) {
  if (memory == nullptr) return cudaSuccess;
  const std::lock_guard lock{machine().mutex};
  const auto found{machine().allocated.find(memory)};
  if (found == machine().allocated.end()) return cudaErrorInvalidValue;
  machine().memory += found->second;
  machine().allocated.erase(found);
  std::free(memory);
  return cudaSuccess;
}
cudaError_t cudaMallocHost(void** memory, std::size_t bytes) {
  *memory = std::malloc(bytes);
  return cudaSuccess;
}
cudaError_t cudaFreeHost(void* memory) {
  std::free(memory);
  return cudaSuccess;
}
cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind /*kind*/,
                            cudaStream_t stream) {
  if (bytes == 0) return cudaErrorInvalidValue;  // as a graph does
  return give(stream, [=] { std::memmove(to, from, bytes); });
}
cudaError_t cudaMemcpy2DAsync(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch,
                              std::size_t row_bytes, std::size_t rows, cudaMemcpyKind kind, cudaStream_t stream) {
  if (to_pitch < row_bytes || from_pitch < row_bytes) return cudaErrorInvalidValue;
  for (std::size_t row{0}; row < rows; ++row) {
    cudaMemcpyAsync(static_cast<char*>(to) + row * to_pitch, static_cast<const char*>(from) + row * from_pitch,
                    row_bytes, kind, stream);
  }
  return cudaSuccess;
}
cudaError_t cudaMemsetAsync(void* memory, int value, std::size_t bytes, cudaStream_t stream) {
  if (bytes == 0) return cudaErrorInvalidValue;
  return give(stream, [=] { std::memset(memory, value, bytes); });
}

cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned /*flags*/) {
  *stream = new EmulatedStream;
  return cudaSuccess;
}
cudaError_t cudaStreamDestroy(cudaStream_t stream) {
  delete stream;
  return cudaSuccess;
}
cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
  return stream != nullptr && stream->captured != nullptr ? cudaErrorStreamCaptureUnsupported : cudaSuccess;
}
cudaError_t cudaEventCreate(cudaEvent_t* event) {
  return cudaEventCreateWithFlags(event, 0);
}
cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned /*flags*/) {
  *event = new EmulatedEvent;
  return cudaSuccess;
}
cudaError_t cudaEventDestroy(cudaEvent_t event) {
  delete event;
  return cudaSuccess;
}
cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t stream) {
  return give(stream, [event, is_of_graph = stream != nullptr && stream->captured != nullptr] {
    *event = {std::chrono::steady_clock::now(), is_of_graph};
  });
}
cudaError_t cudaEventRecordWithFlags(cudaEvent_t event, cudaStream_t stream, unsigned flags) {
  // this flag is for graphs only
  if (flags == cudaEventRecordExternal && stream->captured == nullptr) return cudaErrorInvalidValue;
  return cudaEventRecord(event, stream);
}
cudaError_t cudaEventSynchronize(cudaEvent_t event) {
  return has_device_set && !event->is_of_graph ? missing() : cudaErrorInvalidValue;
}
cudaError_t cudaStreamWaitEvent(cudaStream_t stream, cudaEvent_t event, unsigned /*flags*/) {
  return event->is_of_graph ? cudaErrorInvalidValue : give(stream, [] {});
}
cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t start, cudaEvent_t end) {
  *milliseconds = std::chrono::duration<float, std::milli>(end->when - start->when).count();
  return cudaSuccess;
}

cudaError_t cudaStreamBeginCapture(cudaStream_t stream, cudaStreamCaptureMode /*mode*/) {
  stream->captured = new EmulatedGraph;
  ++machine().captures;
  ++own_captures;
  return cudaSuccess;
}
cudaError_t cudaStreamIsCapturing(cudaStream_t stream, cudaStreamCaptureStatus* status) {
  *status = stream->captured != nullptr ? cudaStreamCaptureStatusActive : cudaStreamCaptureStatusNone;
  return cudaSuccess;
}
cudaError_t cudaStreamEndCapture(cudaStream_t stream, cudaGraph_t* graph) {
  *graph = std::exchange(stream->captured, nullptr);
  --machine().captures;
  --own_captures;
  return cudaSuccess;
}
cudaError_t cudaGraphInstantiate(cudaGraphExec_t* executable, cudaGraph_t graph, unsigned long long /*flags*/) {
  *executable = new EmulatedGraph{*graph};
  return cudaSuccess;
}
cudaError_t cudaGraphUpload(cudaGraphExec_t /*executable*/, cudaStream_t /*stream*/) {
  return cudaSuccess;
}
cudaError_t cudaGraphLaunch(cudaGraphExec_t executable, cudaStream_t stream) {
  for (const auto& work : executable->work) {
    if (const cudaError_t status{give(stream, work)}; status != cudaSuccess) return status;
  }
  return cudaSuccess;
}
cudaError_t cudaGraphDestroy(cudaGraph_t graph) {
  delete graph;
  return cudaSuccess;
}
cudaError_t cudaGraphExecDestroy(cudaGraphExec_t executable) {
  delete executable;
  return cudaSuccess;
}
