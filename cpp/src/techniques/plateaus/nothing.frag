// For draws that only write buffers.
void main() {}
