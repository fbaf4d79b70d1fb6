// SPDX-License-Identifier: Apache-2.0
#include "participant.hpp"

#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>

#include "stereogrid/error.hpp"

namespace stereogrid::dds {
namespace {

constexpr std::size_t word_bytes{4};  // DDS pads samples to whole words
constexpr std::size_t largest_bytes{std::numeric_limits<std::uint32_t>::max() - word_bytes};

struct Sample : ddsi_serdata {
  Sample(const ddsi_sertype* type_of_it, ddsi_serdata_kind kind_of_it, std::size_t bytes)
      : ddsi_serdata{}, size{bytes} {
    ddsi_serdata_init(this, type_of_it, kind_of_it);
    const std::size_t padded{(bytes + word_bytes - 1) / word_bytes * word_bytes};
    data = std::make_unique_for_overwrite<std::byte[]>(padded);
    std::fill(data.get() + bytes, data.get() + padded, std::byte{0});
  }

  std::size_t size;
  std::unique_ptr<std::byte[]> data;
};

const Sample& sample_of(const ddsi_serdata* data) {
  return *static_cast<const Sample*>(data);
}

// No exceptions: Cyclone DDS is C. A null pointer marks an invalid sample.
template <class Fill>
ddsi_serdata* made(const ddsi_sertype* type, ddsi_serdata_kind kind, std::size_t bytes, Fill&& fill) noexcept {
  try {
    auto sample{std::make_unique<Sample>(type, kind, bytes)};
    fill(*sample);
    return sample.release();
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

bool equal_keys(const ddsi_serdata* /*a*/, const ddsi_serdata* /*b*/) {
  return true;  // no keys: one instance
}

std::uint32_t size_of(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(sample_of(data).size);
}

// Fragments come in their order and may overlap.
ddsi_serdata* from_network(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                           std::size_t bytes) {
  return made(type, kind, bytes, [&](Sample& sample) {
    std::uint32_t done{0};
    for (; fragment != nullptr; fragment = fragment->nextfrag) {
      const auto end{static_cast<std::uint32_t>(std::min<std::size_t>(fragment->maxp1, bytes))};
      if (end <= done || fragment->min > done) continue;
      const unsigned char* const payload{NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment))};
      std::memcpy(sample.data.get() + done, payload + (done - fragment->min), end - done);
      done = end;
    }
    std::fill(sample.data.get() + done, sample.data.get() + bytes, std::byte{0});
  });
}

ddsi_serdata* from_memory(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t pieces,
                          const ddsrt_iovec_t* piece, std::size_t bytes) {
  return made(type, kind, bytes, [&](Sample& sample) {
    std::size_t done{0};
    for (const ddsrt_iovec_t& one : std::span{piece, static_cast<std::size_t>(pieces)}) {
      const std::size_t count{std::min<std::size_t>(one.iov_len, bytes - done)};
      if (count > 0) std::memcpy(sample.data.get() + done, one.iov_base, count);
      done += count;
    }
    std::fill(sample.data.get() + done, sample.data.get() + bytes, std::byte{0});
  });
}

ddsi_serdata* from_key_hash(const ddsi_sertype* type, const ddsi_keyhash* /*hash*/) {
  return made(type, SDK_KEY, 0, [](Sample&) {});
}

ddsi_serdata* from_value(const ddsi_sertype* /*type*/, ddsi_serdata_kind /*kind*/, const void* /*value*/) {
  return nullptr;  // dds_write() is not for these types
}

void copy_out(const ddsi_serdata* data, std::size_t offset, std::size_t bytes, void* to) {
  std::memcpy(to, sample_of(data).data.get() + offset, bytes);
}

ddsi_serdata* ref_bytes(const ddsi_serdata* data, std::size_t offset, std::size_t bytes, ddsrt_iovec_t* reference) {
  reference->iov_base = sample_of(data).data.get() + offset;
  reference->iov_len = static_cast<ddsrt_iov_len_t>(bytes);
  return ddsi_serdata_ref(data);
}

void take_back(ddsi_serdata* data, const ddsrt_iovec_t* /*reference*/) {
  ddsi_serdata_unref(data);
}

bool to_value(const ddsi_serdata* /*data*/, void* /*value*/, void** /*buffer*/, void* /*end*/) {
  return false;
}

ddsi_serdata* without_type(const ddsi_serdata* data) {
  return made(data->type, SDK_KEY, 0, [](Sample& sample) { sample.type = nullptr; });
}

bool key_to_value(const ddsi_sertype* /*type*/, const ddsi_serdata* /*data*/, void* /*value*/, void** /*buffer*/,
                  void* /*end*/) {
  return true;  // a key of nothing
}

void free_sample(ddsi_serdata* data) {
  const std::unique_ptr<Sample> freed{static_cast<Sample*>(data)};
}

std::size_t print(const ddsi_sertype* type, const ddsi_serdata* data, char* text, std::size_t size) {
  const int length{
      std::snprintf(text, size, "%s, %zu bytes", type == nullptr ? "" : type->type_name, sample_of(data).size)};
  return length < 0 ? 0 : static_cast<std::size_t>(length);
}

void key_hash(const ddsi_serdata* /*data*/, ddsi_keyhash* hash, bool /*by_md5*/) {
  *hash = {};
}

const ddsi_serdata_ops sample_functions{
    .eqkey = equal_keys,
    .get_size = size_of,
    .from_ser = from_network,
    .from_ser_iov = from_memory,
    .from_keyhash = from_key_hash,
    .from_sample = from_value,
    .to_ser = copy_out,
    .to_ser_ref = ref_bytes,
    .to_ser_unref = take_back,
    .to_sample = to_value,
    .to_untyped = without_type,
    .untyped_to_sample = key_to_value,
    .free = free_sample,
    .print = print,
    .get_keyhash = key_hash,
#ifdef DDS_HAS_SHM  // not used: it needs types of one size, or functions that are left out below
    .get_sample_size = nullptr,
    .from_iox_buffer = nullptr,
#endif
};

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  const std::unique_ptr<ddsi_sertype> freed{type};
}

bool equal_types(const ddsi_sertype* /*a*/, const ddsi_sertype* /*b*/) {
  return true;  // names have been compared
}

std::uint32_t hash_of_type(const ddsi_sertype* /*type*/) {
  return 0;  // the hash of the name is added
}

void zero_values(const ddsi_sertype* /*type*/, void* /*values*/, std::size_t /*count*/) {}

void resize_values(void** /*pointers*/, const ddsi_sertype* /*type*/, void* /*old*/, std::size_t /*old_count*/,
                   std::size_t /*count*/) {}

void free_values(const ddsi_sertype* /*type*/, void** /*pointers*/, std::size_t /*count*/, dds_free_op_t /*what*/) {}

ddsi_sertype* same_type(const ddsi_sertype* type, dds_data_representation_id_t /*of*/,
                        dds_type_consistency_enforcement_qospolicy_t /*rules*/) {
  return const_cast<ddsi_sertype*>(type);  // there is one representation
}

const ddsi_sertype_ops type_functions{
    .version = ddsi_sertype_v0,
    .arg = nullptr,
    .free = free_type,
    .zero_samples = zero_values,
    .realloc_samples = resize_values,
    .free_samples = free_values,
    .equal = equal_types,
    .hash = hash_of_type,
    .type_id = nullptr,  // peers compare names, as those of ROS do
    .type_map = nullptr,
    .type_info = nullptr,
    .derive_sertype = same_type,
    .get_serialized_size = nullptr,
    .serialize_into = nullptr,
};

}  // namespace

ddsi_sertype* new_bytes_type(const std::string& name) {
  auto type{std::make_unique<ddsi_sertype>()};
  ddsi_sertype_init_flags(type.get(), name.c_str(), &type_functions, &sample_functions,
                          DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type.release();
}

ddsi_serdata* new_sample(const ddsi_sertype* type, std::span<const std::byte> cdr) {
  if (cdr.size() < word_bytes || cdr.size() > largest_bytes) {
    throw InputError{"ROS 2", "a message of " + std::to_string(cdr.size()) + " bytes cannot be sent.",
                     "DDS takes 4 bytes to 4 GiB."};
  }
  ddsi_serdata* const sample{
      made(type, SDK_DATA, cdr.size(), [&](Sample& to_fill) { std::ranges::copy(cdr, to_fill.data.get()); })};
  if (sample == nullptr) throw std::bad_alloc{};
  return sample;
}

std::span<const std::byte> bytes_of(const ddsi_serdata* sample) {
  const Sample& one{sample_of(sample)};
  return {one.data.get(), one.size};
}

}  // namespace stereogrid::dds
