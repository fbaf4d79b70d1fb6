// SPDX-License-Identifier: Apache-2.0
#include "backend/cuda.hpp"

#include <cstring>
#include <string>
#include <thread>
#include <utility>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr int oldest_major{7};
constexpr int oldest_minor{5};

thread_local CudaBytes allocated;

int attribute(cudaDeviceAttr which, int device) {
  int value{0};
  check_cuda(cudaDeviceGetAttribute(&value, which, device), "ask for the device's properties");
  return value;
}

std::string version_text(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

void require_device(int device) {
  int devices{0};
  const cudaError_t status{cudaGetDeviceCount(&devices)};
  if (status == cudaErrorInsufficientDriver) {
    int driver{0};
    cudaDriverGetVersion(&driver);
    throw DeviceError{driver == 0 ? "No NVIDIA driver is installed on this machine."
                                  : "The NVIDIA driver is too old: it serves CUDA " + version_text(driver) +
                                        ", and this program was built for CUDA " + version_text(CUDART_VERSION) +
                                        ". Install a newer driver."};
  }
  if (status == cudaErrorNoDevice || (status == cudaSuccess && devices == 0)) {
    throw DeviceError{"No NVIDIA GPU was found on this machine."};
  }
  check_cuda(status, "look for a GPU");
  if (device < devices) return;
  throw DeviceError{"There is no GPU " + std::to_string(device) + " on this machine: there are " +
                    std::to_string(devices) + ", counted from 0."};
}

void require_architecture(int device) {
  const int major{attribute(cudaDevAttrComputeCapabilityMajor, device)};
  const int minor{attribute(cudaDevAttrComputeCapabilityMinor, device)};
  if (major * 10 + minor >= oldest_major * 10 + oldest_minor) return;
  throw DeviceError{"The GPU is too old: its compute capability is " + std::to_string(major) + "." +
                    std::to_string(minor) + ", 7.5 (Turing, 2018) or later is needed."};
}

// Stands for all kernels: they are compiled for the same devices.
__global__ void any_kernel() {}

// A device may be new or old enough that nothing in this file runs on it; said here, it is not said by the first
// launch.
void require_kernels(int device) {
  cudaFuncAttributes attributes{};
  const cudaError_t status{cudaFuncGetAttributes(&attributes, reinterpret_cast<const void*>(any_kernel))};
  if (status == cudaErrorNoKernelImageForDevice || status == cudaErrorInvalidDeviceFunction ||
      status == cudaErrorUnsupportedPtxVersion) {
    cudaGetLastError();
    throw DeviceError{"This build has no code for the GPU, whose compute capability is " +
                      std::to_string(attribute(cudaDevAttrComputeCapabilityMajor, device)) + "." +
                      std::to_string(attribute(cudaDevAttrComputeCapabilityMinor, device)) +
                      ". Add that to CMAKE_CUDA_ARCHITECTURES and build again, or install a newer driver."};
  }
  check_cuda(status, "load its kernels");
}

[[noreturn]] void throw_out_of_memory(const char* whose, std::size_t bytes) {
  throw DeviceError{std::string{whose} + " memory is too small: " + std::to_string((bytes >> 20) + 1) +
                    " MiB more were requested. Use smaller images, fewer disparities or a smaller grid, or end other "
                    "programs that use the GPU."};
}

}  // namespace

void check_cuda(cudaError_t status, const char* doing) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // clears the error, if it can be cleared
  throw DeviceError{std::string{"CUDA could not "} + doing + ": " + cudaGetErrorString(status) + "."};
}

Cuda::Cuda(int device) : device_{device} {
  require_device(device);
  require_architecture(device);
  use();
  require_kernels(device);
  multiprocessors_ = attribute(cudaDevAttrMultiProcessorCount, device);
  check_cuda(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "create a stream");
  idle_ = create_event();
}

Cuda::~Cuda() {
  cudaEventDestroy(idle_);
  cudaStreamDestroy(stream_);
}

void Cuda::use() const {
  check_cuda(cudaSetDevice(device_), "choose a GPU");
}

void Cuda::synchronize() {
  check_cuda(cudaEventRecord(idle_, stream_), "finish its work");
  check_cuda(cudaEventSynchronize(idle_), "finish its work");
}

void Cuda::load(const std::function<void()>& work) {
  is_loading_ = true;
  try {
    work();
  } catch (...) {
    is_loading_ = false;
    throw;
  }
  is_loading_ = false;
}

cudaEvent_t create_event() {
  int device{0};
  check_cuda(cudaGetDevice(&device), "create an event");
  const unsigned flags{wait_flags(std::thread::hardware_concurrency(), attribute(cudaDevAttrIntegrated, device) != 0)};
  cudaEvent_t event{};
  check_cuda(cudaEventCreateWithFlags(&event, flags), "create an event");
  return event;
}

void load_kernel(const void* kernel) {
  cudaFuncAttributes attributes{};
  check_cuda(cudaFuncGetAttributes(&attributes, kernel), "load a kernel");
}

Graph::~Graph() {
  if (executable_ != nullptr) cudaGraphExecDestroy(executable_);
}

void Graph::capture(Cuda& cuda, const std::function<void()>& work) {
  check_cuda(cudaStreamBeginCapture(cuda.stream(), cudaStreamCaptureModeThreadLocal), "record a graph");
  cudaGraph_t graph{};
  try {
    work();
  } catch (...) {
    if (cudaStreamEndCapture(cuda.stream(), &graph) == cudaSuccess) cudaGraphDestroy(graph);
    throw;
  }
  check_cuda(cudaStreamEndCapture(cuda.stream(), &graph), "record a graph");
  if (executable_ != nullptr) cudaGraphExecDestroy(std::exchange(executable_, nullptr));
  const cudaError_t status{cudaGraphInstantiate(&executable_, graph, 0)};
  cudaGraphDestroy(graph);
  check_cuda(status, "prepare a graph");
  check_cuda(cudaGraphUpload(executable_, cuda.stream()), "prepare a graph");  // else the first launch does
}

void Graph::launch(Cuda& cuda) {
  check_cuda(cudaGraphLaunch(executable_, cuda.stream()), "start a graph");
}

CudaBytes cuda_bytes_allocated() {
  return allocated;
}

void* allocate_on_device(std::size_t bytes) {
  void* memory{nullptr};
  const cudaError_t status{cudaMalloc(&memory, bytes == 0 ? 1 : bytes)};
  if (status == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw_out_of_memory("The GPU's", bytes);
  }
  check_cuda(status, "allocate device memory");
  allocated.device += bytes;
  return memory;
}

void* allocate_cleared_on_device(std::size_t bytes) {
  void* memory{allocate_on_device(bytes)};
  if (bytes == 0) return memory;
  // the whole device must not be queried: another thread may be recording a graph
  check_cuda(cudaMemsetAsync(memory, 0, bytes, cudaStreamPerThread), "clear device memory");
  check_cuda(cudaStreamSynchronize(cudaStreamPerThread), "clear device memory");
  return memory;
}

void* allocate_pinned(std::size_t bytes) {
  void* memory{nullptr};
  const cudaError_t status{cudaMallocHost(&memory, bytes == 0 ? 1 : bytes)};
  if (status == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    throw_out_of_memory("The host's", bytes);
  }
  check_cuda(status, "allocate pinned memory");
  allocated.pinned += bytes;
  std::memset(memory, 0, bytes);
  return memory;
}

}  // namespace stereogrid
