// SPDX-License-Identifier: Apache-2.0
//
// LD_PRELOAD library: makes one system call fail, of those that change files below a folder, or that query them.
//   STEREOGRID_FAULTS_UNDER   the folder, as an absolute path without symbolic links
//   STEREOGRID_FAULTS_REPORT  a file that gets a line for each such call: its name and the file
//   STEREOGRID_FAULTS_CALL    which call fails, from 1; 0 or none: none does
//   STEREOGRID_FAULTS_OF      queries: stat(), opendir() and their like are counted; else those that change files
//   STEREOGRID_FAULTS_KIND    EIO, ESTALE, ENOSPC or EINTR: it fails without an effect (close: with its effect);
//                             short: a write writes half of its bytes; full: it, and nothing from there on;
//                             kill: the process is killed instead of the call
//   STEREOGRID_FAULTS_FLOCK   ENOLCK: no file can be locked
//   STEREOGRID_FAULTS_HANG    a file: opening it never returns, as on a disconnected network file system
//   STEREOGRID_FAULTS_READ    a file whose reads fail (EIO), as an absolute path without symbolic links
//   STEREOGRID_FAULTS_READ_AFTER  only once this file exists
//   STEREOGRID_FAULTS_THREAD  which thread, from 1, and all after it cannot be started (EAGAIN); those that OpenBLAS
//                             starts before main() are not counted
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

/// The function that this library stands before.
template <class Function>
Function* real(Function* /*same*/, const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define REAL(name) real(&name, #name)

std::string variable(const char* name) {
  const char* const value{std::getenv(name)};
  return value == nullptr ? "" : value;
}

enum class Fault { none, error, half };

class Plan {
 public:
  [[nodiscard]] bool concerns(std::string_view path) const {
    return !under_.empty() && path.starts_with(under_) && (path.size() == under_.size() || path[under_.size()] == '/');
  }

  /// Counts a call and returns its fault. `bytes`: of a write, else 0. Sets errno.
  Fault next(const char* call, std::string_view path, std::size_t bytes) {
    const int number{++count_};
    report(call, path);
    if (call_ == 0 || number < call_) return Fault::none;
    if (kind_ == "full") return full(number, bytes);
    if (number > call_) return Fault::none;
    if (kind_ == "kill") kill(getpid(), SIGKILL);
    if (kind_ == "short") return bytes > 1 ? Fault::half : Fault::none;
    errno = kind_ == "ENOSPC" ? ENOSPC : kind_ == "EINTR" ? EINTR : kind_ == "ESTALE" ? ESTALE : EIO;
    return Fault::error;
  }

  [[nodiscard]] bool is_of_queries() const { return is_of_queries_; }

 private:
  [[nodiscard]] Fault full(int number, std::size_t bytes) const {
    if (bytes == 0) return Fault::none;
    if (number == call_ && bytes > 1) return Fault::half;
    errno = ENOSPC;
    return Fault::error;
  }

  void report(const char* call, std::string_view path) const {
    if (report_.empty()) return;
    const std::string line{std::string{call} + " " + std::string{path} + "\n"};
    const auto file{static_cast<int>(
        syscall(SYS_openat, AT_FDCWD, report_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666))};
    syscall(SYS_write, file, line.data(), line.size());
    syscall(SYS_close, file);
  }

  std::string under_{variable("STEREOGRID_FAULTS_UNDER")};
  std::string report_{variable("STEREOGRID_FAULTS_REPORT")};
  std::string kind_{variable("STEREOGRID_FAULTS_KIND")};
  bool is_of_queries_{variable("STEREOGRID_FAULTS_OF") == "queries"};
  int call_{std::atoi(variable("STEREOGRID_FAULTS_CALL").c_str())};
  std::atomic<int> count_{0};
};

Plan& plan() {
  static Plan the_plan;
  return the_plan;
}

/// "": not open.
std::string target_of(int descriptor) {
  char target[PATH_MAX];
  const std::string link{"/proc/self/fd/" + std::to_string(descriptor)};
  const ssize_t length{readlink(link.c_str(), target, sizeof target)};
  return {target, length > 0 ? static_cast<std::size_t>(length) : 0};
}

/// Name of an open file; "": none of those that count: read only, or the lock, on whose close nothing depends.
std::string path_of(int descriptor) {
  if ((fcntl(descriptor, F_GETFL) & O_ACCMODE) == O_RDONLY) return {};
  const std::string path{target_of(descriptor)};
  return plan().concerns(path) ? path : "";
}

/// Sets errno.
bool is_read_to_fail(int descriptor) {
  static const std::string failing{variable("STEREOGRID_FAULTS_READ")};
  static const std::string after{variable("STEREOGRID_FAULTS_READ_AFTER")};
  if (failing.empty() || target_of(descriptor) != failing) return false;
  if (!after.empty() && access(after.c_str(), F_OK) != 0) return false;
  errno = EIO;
  return true;
}

bool may_start_thread(const void* caller) {
  static const int failing{std::atoi(variable("STEREOGRID_FAULTS_THREAD").c_str())};
  static std::atomic<int> started{0};
  Dl_info module{};
  const bool is_counted{dladdr(caller, &module) == 0 || strstr(module.dli_fname, "openblas") == nullptr};
  return failing == 0 || !is_counted || ++started < failing;
}

bool is_lock(std::string_view path) {
  return path.find("/.lock") != std::string_view::npos;
}

Fault fault_of(const char* call, const std::string& path, std::size_t bytes = 0) {
  return plan().concerns(path) && !plan().is_of_queries() ? plan().next(call, path, bytes) : Fault::none;
}

/// Sets errno.
bool is_query_to_fail(const char* call, std::string_view path) {
  return plan().is_of_queries() && plan().concerns(path) && plan().next(call, path, 0) == Fault::error;
}

template <class Function>
int open_before(Function* function, const char* path, int flags, mode_t mode) {
  static const std::string hanging{variable("STEREOGRID_FAULTS_HANG")};
  while (!hanging.empty() && hanging == path) pause();
  const bool writes{(flags & O_ACCMODE) != O_RDONLY};
  if (writes && fault_of("open", path) == Fault::error) return -1;
  return function(path, flags, mode);
}

mode_t mode_of(int flags, va_list arguments) {
  return (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode{mode_of(flags, arguments)};
  va_end(arguments);
  return open_before(REAL(open), path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode{mode_of(flags, arguments)};
  va_end(arguments);
  return open_before(REAL(open64), path, flags, mode);
}

FILE* fopen(const char* path, const char* mode) {
  if (mode[0] != 'r' && fault_of("open", path) == Fault::error) return nullptr;
  return REAL(fopen)(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  if (mode[0] != 'r' && fault_of("open", path) == Fault::error) return nullptr;
  return REAL(fopen64)(path, mode);
}

ssize_t read(int descriptor, void* bytes, size_t count) {
  return is_read_to_fail(descriptor) ? -1 : REAL(read)(descriptor, bytes, count);
}

ssize_t pread(int descriptor, void* bytes, size_t count, off_t at) {
  return is_read_to_fail(descriptor) ? -1 : REAL(pread)(descriptor, bytes, count, at);
}

ssize_t pread64(int descriptor, void* bytes, size_t count, off64_t at) {
  return is_read_to_fail(descriptor) ? -1 : REAL(pread64)(descriptor, bytes, count, at);
}

ssize_t write(int descriptor, const void* bytes, size_t count) {
  const Fault fault{fault_of("write", path_of(descriptor), count)};
  if (fault == Fault::error) return -1;
  return REAL(write)(descriptor, bytes, fault == Fault::half ? count / 2 : count);
}

ssize_t writev(int descriptor, const struct iovec* parts, int count) {
  std::size_t bytes{0};
  for (int i{0}; i < count; ++i) bytes += parts[i].iov_len;
  const Fault fault{fault_of("write", path_of(descriptor), bytes)};
  if (fault == Fault::error) return -1;
  if (fault == Fault::half) return REAL(write)(descriptor, parts[0].iov_base, (parts[0].iov_len + 1) / 2);
  return REAL(writev)(descriptor, parts, count);
}

int close(int descriptor) {
  const std::string path{path_of(descriptor)};
  if (is_lock(path)) return REAL(close)(descriptor);
  const Fault fault{fault_of("close", path)};
  const int error_number{errno};
  const int result{REAL(close)(descriptor)};
  if (fault != Fault::error) return result;
  errno = error_number;
  return -1;
}

int fclose(FILE* file) {
  const Fault fault{fault_of("close", path_of(fileno(file)))};
  const int error_number{errno};
  const int result{REAL(fclose)(file)};
  if (fault != Fault::error) return result;
  errno = error_number;
  return EOF;
}

int fsync(int descriptor) {
  return fault_of("fsync", path_of(descriptor)) == Fault::error ? -1 : REAL(fsync)(descriptor);
}

int fdatasync(int descriptor) {
  return fault_of("fsync", path_of(descriptor)) == Fault::error ? -1 : REAL(fdatasync)(descriptor);
}

int ftruncate(int descriptor, off_t size) noexcept {
  return fault_of("truncate", path_of(descriptor)) == Fault::error ? -1 : REAL(ftruncate)(descriptor, size);
}

int truncate(const char* path, off_t size) noexcept {
  return fault_of("truncate", path) == Fault::error ? -1 : REAL(truncate)(path, size);
}

int truncate64(const char* path, off64_t size) noexcept {
  return fault_of("truncate", path) == Fault::error ? -1 : REAL(truncate64)(path, size);
}

int rename(const char* from, const char* to) noexcept {
  return fault_of("rename", to) == Fault::error ? -1 : REAL(rename)(from, to);
}

int mkdir(const char* path, mode_t mode) noexcept {
  return fault_of("mkdir", path) == Fault::error ? -1 : REAL(mkdir)(path, mode);
}

int stat(const char* path, struct stat* status) noexcept {
  return is_query_to_fail("stat", path) ? -1 : REAL(stat)(path, status);
}

int lstat(const char* path, struct stat* status) noexcept {
  return is_query_to_fail("lstat", path) ? -1 : REAL(lstat)(path, status);
}

int fstat(int descriptor, struct stat* status) noexcept {
  return is_query_to_fail("fstat", target_of(descriptor)) ? -1 : REAL(fstat)(descriptor, status);
}

DIR* opendir(const char* path) {
  return is_query_to_fail("opendir", path) ? nullptr : REAL(opendir)(path);
}

struct dirent* readdir(DIR* folder) {
  return is_query_to_fail("readdir", target_of(dirfd(folder))) ? nullptr : REAL(readdir)(folder);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*work)(void*), void* argument) noexcept {
  if (!may_start_thread(__builtin_return_address(0))) return EAGAIN;
  return REAL(pthread_create)(thread, attributes, work, argument);
}

int flock(int descriptor, int operation) noexcept {
  if (variable("STEREOGRID_FAULTS_FLOCK") != "ENOLCK") return REAL(flock)(descriptor, operation);
  errno = ENOLCK;
  return -1;
}

}  // extern "C"
