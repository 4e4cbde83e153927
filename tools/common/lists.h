#pragma once

#include <string>
#include <vector>

namespace surfit::tools {

// The parts of a text between commas; none of an empty text.
std::vector<std::string> Names(const std::string& text);

// Numbers between commas. Throws InputError naming the flag for anything else.
std::vector<double> NumberList(const char* flag, const std::string& text);
std::vector<int> IntegerList(const char* flag, const std::string& text);

// "a,b,c", what these flags take.
std::string Joined(const std::vector<double>& numbers);
std::string Joined(const std::vector<int>& numbers);

}  // namespace surfit::tools
