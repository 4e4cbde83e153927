// An empty program: the test is that it links.
int main() { return 0; }
