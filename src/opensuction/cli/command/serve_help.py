"""Help text of ``serve``."""

SERVE = (
    "As run, but nothing starts by itself: people ask, at the bedside console in a browser or with "
    "opensuction ask from another terminal. The console is a process of its own; its address is "
    "printed, and at the first start the administrator's one-time password, which makes the other "
    "accounts. Everybody may look and stop, without signing in; a clinician starts; an engineer "
    "changes limits and calibrates. It is reached from this computer alone, unless --host says "
    "otherwise, and then only with a certificate. When the console dies the machine goes on, says "
    "so, and the console is started anew. Ends with Ctrl-C or SIGTERM, the catheter first. Linux "
    "only."
)
SERVE_EXAMPLES = """\b
Examples:
  opensuction serve --patient neonate            http://127.0.0.1:8080/
  opensuction serve --port 8081 --name ward-3    a second machine beside it
  opensuction ask abort                          stop, from another terminal
  opensuction users reset-password admin         the first password is lost

\b
From another computer, with a certificate that its browser trusts; for a try:
  openssl req -x509 -newkey rsa:3072 -nodes -days 30 -keyout key.pem \\
    -out cert.pem -subj /CN=ward -addext subjectAltName=DNS:$(hostname)
  opensuction serve --host 0.0.0.0 --certificate cert.pem --key key.pem

\b
Files:
  /dev/shm/opensuction-UID/NAME   what the processes share, in memory; and
                                  console.log, what the console refused
  runs/TIME-NAME/*.mcap           a recording for each cycle"""
