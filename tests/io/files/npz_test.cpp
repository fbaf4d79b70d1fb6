// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/npz.hpp"

#include <limits>
#include <random>

#include "stereogrid/io/file.hpp"
#include "support.hpp"

namespace stereogrid::io::testing {
namespace {

using Npz = FolderTest;

template <class T>
void expect_round_trip(const std::vector<T>& values) {
  const TemporaryFolder folder;
  const std::vector<NpzArray> arrays{{"values", {values.size()}, values}};
  write_npz(folder / "a.npz", arrays);
  const NpyArray read{read_npz(folder / "a.npz").at("values")};
  EXPECT_EQ(read.dtype, dtype_of<T>());
  EXPECT_EQ(read.shape, std::vector<std::size_t>{values.size()});
  EXPECT_EQ(read.template to<T>(), values);
}

TEST_F(Npz, RoundTripsEveryType) {
  expect_round_trip<float>({1.5F, -0.0F, std::numeric_limits<float>::infinity(), 3e38F});
  expect_round_trip<double>({1e300, -2.5});
  expect_round_trip<std::int32_t>({-5, 2147483647});
  expect_round_trip<std::int64_t>({-5, std::numeric_limits<std::int64_t>::max()});
  expect_round_trip<std::uint8_t>({0, 255});
  expect_round_trip<std::uint16_t>({0, 65535});
  expect_round_trip<float>({});
}

TEST_F(Npz, HalvesKeepThreeDigits) {
  const std::vector<float> values{0.5F, 1.0F / 3, -12.0625F, 255.0F / 256, std::numeric_limits<float>::infinity()};
  std::vector<Half> halves;
  for (const float value : values) halves.emplace_back(value);
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"values", {halves.size()}, halves}});
  const NpyArray read{read_npz(folder / "a.npz").at("values")};
  EXPECT_EQ(spelling(read.dtype), "<f2");
  const std::vector<float> back{read.to<float>()};
  for (const std::size_t i : {0U, 2U, 3U, 4U}) EXPECT_EQ(back.at(i), values.at(i));
  EXPECT_NEAR(back.at(1), 1.0 / 3, 0.0002);
  EXPECT_EQ(read.to<std::int32_t>().at(2), -12);
}

TEST_F(Npz, KeepsShapesAndImages) {
  Image<float> image{3, 2, 1};
  image(2, 1) = 9;
  const std::vector<double> cube(24, 0.5);
  const std::vector<double> one{7};
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"image", image}, {"cube", {2, 3, 4}, cube}, {"scalar", {}, one}});
  const auto read{read_npz(folder / "a.npz")};
  EXPECT_EQ(read.at("image").shape, (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(read.at("image").to_image<float>(), image);
  EXPECT_EQ(read.at("cube").shape, (std::vector<std::size_t>{2, 3, 4}));
  EXPECT_TRUE(read.at("scalar").shape.empty());
  EXPECT_EQ(read.at("scalar").to<std::int32_t>(), std::vector<std::int32_t>{7});
  EXPECT_THROW(static_cast<void>(read.at("cube").to_image<float>()), InputError);
}

TEST_F(Npz, FloatsThatAnIntegerCannotHoldBecomeItsNearest) {
  const std::vector<double> values{-1.5, 2.75, 1e300, std::numeric_limits<double>::quiet_NaN()};
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"a", {values.size()}, values}});
  const NpyArray read{read_npz(folder / "a.npz").at("a")};
  EXPECT_EQ(read.to<std::uint8_t>(), (std::vector<std::uint8_t>{0, 2, 255, 0}));
  EXPECT_EQ(read.to<std::int64_t>(), (std::vector<std::int64_t>{-1, 2, std::numeric_limits<std::int64_t>::max(), 0}));
}

TEST_F(Npz, TheSameArraysGiveTheSameBytes) {
  const std::vector<float> values(1000, 0.5F);
  const std::vector<NpzArray> arrays{{"a", {10, 100}, values}};
  write_npz(folder / "a.npz", arrays);
  write_npz(folder / "b.npz", arrays);
  EXPECT_EQ(read_file(folder / "a.npz"), read_file(folder / "b.npz"));
  EXPECT_LT(fs::file_size(folder / "a.npz"), 1000) << "compressed";
}

TEST_F(Npz, NoiseHardlyGrows) {
  std::mt19937 random{3};
  std::vector<std::int32_t> noise(20000);
  for (std::int32_t& value : noise) value = static_cast<std::int32_t>(random());
  std::vector<std::int32_t> steps(20000);
  for (std::size_t i{0}; i < steps.size(); ++i) steps[i] = static_cast<std::int32_t>(i / 100);
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"noise", {20000}, noise}, {"steps", {200, 100}, steps}});
  EXPECT_EQ(read_npz(folder / "a.npz").at("noise").to<std::int32_t>(), noise);
  EXPECT_EQ(read_npz(folder / "a.npz").at("steps").to<std::int32_t>(), steps);
  EXPECT_GT(fs::file_size(folder / "a.npz"), 80000);
  EXPECT_LT(fs::file_size(folder / "a.npz"), 90000);
}

TEST_F(Npz, ShapeThatDoesNotFitIsABug) {
  const std::vector<float> values(5);
  EXPECT_THROW(write_npz(folder / "a.npz", std::vector<NpzArray>{{"a", {2, 3}, values}}), std::invalid_argument);
  EXPECT_FALSE(fs::exists(folder / "a.npz"));
}

TEST_F(Npz, MissingFolderIsADeviceError) {
  const std::vector<float> values(5);
  EXPECT_THROW(write_npz(folder / "none" / "a.npz", std::vector<NpzArray>{{"a", {5}, values}}), DeviceError);
}

TEST_F(Npz, TruncatedFilesAreSeen) {
  std::vector<std::uint16_t> values(500);
  for (std::size_t i{0}; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i * i);
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"a", {500}, values}});
  const std::string whole{read_file(folder / "a.npz")};
  for (std::size_t length{0}; length < whole.size(); length += 13) {
    put(folder / "cut.npz", whole.substr(0, length));
    expect_error([&] { return read_npz(folder / "cut.npz"); }, {"cut.npz"});
  }
}

TEST_F(Npz, DamagedFilesAreSeenOrMakeNoDifference) {
  std::vector<std::uint16_t> values(500);
  for (std::size_t i{0}; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i * i);
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"a", {500}, values}});
  const std::string whole{read_file(folder / "a.npz")};
  std::size_t seen{0};
  for (std::size_t at{0}; at < whole.size(); ++at) {
    std::string damaged{whole};
    damaged[at] = static_cast<char>(damaged[at] ^ 0x11);
    put(folder / "damaged.npz", damaged);
    try {
      const auto arrays{read_npz(folder / "damaged.npz")};
      for (const auto& [name, array] : arrays) EXPECT_EQ(array.to<std::uint16_t>(), values) << "byte " << at;
    } catch (const InputError&) {
      ++seen;
    }
  }
  EXPECT_GT(seen, whole.size() / 2);
}

TEST_F(Npz, NumpyOpensOurs) {
  if (!has_numpy()) GTEST_SKIP() << "/usr/bin/python3 has no numpy";
  Image<float> image{3, 2, 0.25F};
  image(1, 0) = std::numeric_limits<float>::infinity();
  const std::vector<std::int64_t> stamps{1, -2, 1'700'000'000'000'000'000};
  const std::vector<std::uint8_t> bytes{1, 2, 3, 255};
  const std::vector<double> one{3.5};
  write_npz(folder / "a.npz", std::vector<NpzArray>{{"image", image},
                                                    {"stamps", {3}, stamps},
                                                    {"bytes", {2, 1, 2}, bytes},
                                                    {"scalar", {}, one},
                                                    {"none", {0, 4}, std::vector<std::uint16_t>{}}});
  EXPECT_TRUE(run_python(R"(
import numpy as np
with np.load(')" + (folder / "a.npz").string() +
                         R"(') as z:
    assert sorted(z) == ['bytes', 'image', 'none', 'scalar', 'stamps'], list(z)
    assert z['image'].dtype == np.float32 and z['image'].shape == (2, 3)
    assert np.isinf(z['image'][0, 1]) and z['image'][1, 1] == 0.25
    assert z['stamps'].dtype == np.int64 and z['stamps'].tolist() == [1, -2, 1700000000000000000]
    assert z['bytes'].dtype == np.uint8 and z['bytes'].tolist() == [[[1, 2]], [[3, 255]]]
    assert z['scalar'].shape == () and z['scalar'] == 3.5
    assert z['none'].shape == (0, 4) and z['none'].dtype == np.uint16
)"));
}

TEST_F(Npz, WeOpenNumpys) {
  if (!has_numpy()) GTEST_SKIP() << "/usr/bin/python3 has no numpy";
  ASSERT_TRUE(
      run_python("import numpy as np\nnp.random.seed(1)\n"
                 "d = '" +
                 folder.path().string() +
                 "/'\n"
                 "np.savez_compressed(d + 'a.npz', f=np.arange(6, dtype=np.float64).reshape(2, 3), b=np.array([True, "
                 "False]), i=np.array([-3], np.int16), u=np.array([2**40], np.uint64))\n"
                 "np.savez(d + 'stored.npz', x=np.arange(3, dtype=np.int32))\n"
                 "np.savez(d + 'half.npz', x=np.array([0.1, -2.5], np.float16))\n"
                 "np.savez(d + 'complex.npz', x=np.zeros(3, np.complex64))\n"
                 "np.savez(d + 'big.npz', x=np.zeros(3, '>f4'))\n"
                 "np.savez(d + 'columns.npz', x=np.asfortranarray(np.arange(6).reshape(3, 2)))\n"
                 "np.savez(d + 'cubes.npz', x=np.asfortranarray(np.zeros((3, 2, 2))))\n"));
  const auto arrays{read_npz(folder / "a.npz")};
  EXPECT_EQ(arrays.at("f").to_image<float>()(2, 1), 5.0F);
  EXPECT_EQ(arrays.at("b").to<std::uint8_t>(), (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(arrays.at("i").to<std::int32_t>(), std::vector<std::int32_t>{-3});
  EXPECT_EQ(arrays.at("u").to<std::int64_t>(), std::vector<std::int64_t>{std::int64_t{1} << 40});
  EXPECT_EQ(read_npz(folder / "stored.npz").at("x").to<std::int64_t>(), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(read_npz(folder / "half.npz").at("x").to<float>(), (std::vector<float>{0.0999755859375F, -2.5F}));
  expect_error([&] { return read_npz(folder / "complex.npz"); }, {"complex.npz", "x.npy", "<c8"});
  expect_error([&] { return read_npz(folder / "big.npz"); }, {"big.npz", ">f4"});
  EXPECT_EQ(read_npz(folder / "columns.npz").at("x").to<int>(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
  expect_error([&] { return read_npz(folder / "cubes.npz"); }, {"cubes.npz", "column by column"});
}

TEST_F(Npz, ArraysThatAreTooLargeTogetherAreRejected) {
  const std::vector<float> values(std::size_t{1} << 18);
  write_npz(folder / "a.npz",
            std::vector<NpzArray>{{"first", {values.size()}, values}, {"second", {values.size()}, values}});
  const std::size_t both_bytes{2 * (values.size() * sizeof(float) + 128)};  // 128: header
  EXPECT_EQ(read_npz(folder / "a.npz", both_bytes).size(), 2);
  expect_error([&] { return read_npz(folder / "a.npz", both_bytes - 1); },
               {"a.npz, array second.npy", "the most that is read"});
}

TEST_F(Npz, NoArchive) {
  put(folder / "text.npz", "hello");
  expect_error([&] { return read_npz(folder / "text.npz"); }, {"text.npz", "not a whole .npz"});
  expect_error([&] { return read_npz(folder / "none.npz"); }, {"none.npz", "no such file"});
}

}  // namespace
}  // namespace stereogrid::io::testing
