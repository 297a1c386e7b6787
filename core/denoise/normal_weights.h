// The numbers of the networks of normal_network.h, one network after the other. normal_weights.cpp is written
// by tests/train.
#pragma once

#include <span>

namespace burnish {

std::span<const float> normal_weights();

}  // namespace burnish
