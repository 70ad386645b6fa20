// Compiled once so that the precompiled header of the tests exists.
