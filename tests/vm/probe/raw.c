// SPDX-License-Identifier: MIT OR Apache-2.0
/* raw SOCKET: copies what comes from a unix socket to standard output, byte for byte, until it ends. */
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

int main(int argc, char **argv)
{
	struct sockaddr_un at = { .sun_family = AF_UNIX };
	int fd = socket(AF_UNIX, SOCK_STREAM, 0);
	char bytes[4096];
	ssize_t n;

	strncpy(at.sun_path, argc > 1 ? argv[1] : "", sizeof(at.sun_path) - 1);
	if (connect(fd, (struct sockaddr *)&at, sizeof(at))) {
		perror(at.sun_path);
		return 1;
	}
	while ((n = read(fd, bytes, sizeof(bytes))) > 0)
		if (write(STDOUT_FILENO, bytes, n) != n)
			return 1;
	return 0;
}
